// Finds the best of all partitions of a few kinds of destinations into groups, by trying each.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "udp_transport/multicast/plan_cost.h"

namespace sft::udp {

class AllPartitions {
 public:
  /// Where a kind is that is in no group; the others are in groups from 0 on.
  static constexpr std::size_t alone = SIZE_MAX;

  /// `alone_cost` has the cost of each kind that is in no group, `together` that of each set of kinds in one
  /// group: kind i is bit i. Both outlive it.
  AllPartitions(std::span<const PlanCost> alone_cost, std::span<const PlanCost> together,
                std::size_t groups_max)
      : alone_cost_(alone_cost), together_(together), groups_max_(groups_max) {}

  /// The place of each kind in the partition that is judged least.
  std::vector<std::size_t> best(const std::function<double(PlanCost)>& judge);

 private:
  void place(std::size_t kind, PlanCost alone_so_far);
  void weigh(PlanCost alone_so_far);

  const std::span<const PlanCost> alone_cost_, together_;
  const std::size_t groups_max_;
  const std::function<double(PlanCost)>* judge_ = nullptr;
  std::vector<std::size_t> groups_, best_;  ///< each a set of kinds
  double least_ = 0;
};

}  // namespace sft::udp
