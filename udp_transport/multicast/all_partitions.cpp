#include "udp_transport/multicast/all_partitions.h"

#include <limits>

namespace sft::udp {

std::vector<std::size_t> AllPartitions::best(const std::function<double(PlanCost)>& judge) {
  judge_ = &judge;
  least_ = std::numeric_limits<double>::infinity();
  groups_.clear();
  place(0, {});
  std::vector<std::size_t> places(alone_cost_.size(), alone);
  for (std::size_t group = 0; group < best_.size(); ++group) {
    for (std::size_t kind = 0; kind < places.size(); ++kind) {
      if ((best_[group] >> kind & 1) != 0) places[kind] = group;
    }
  }
  return places;
}

void AllPartitions::place(std::size_t kind, PlanCost alone_so_far) {
  if (kind == alone_cost_.size()) return weigh(alone_so_far);
  place(kind + 1, alone_so_far + alone_cost_[kind]);
  const std::size_t bit = std::size_t{1} << kind;
  for (std::size_t i = 0; i < groups_.size(); ++i) {
    groups_[i] |= bit;
    place(kind + 1, alone_so_far);
    groups_[i] &= ~bit;
  }
  if (groups_.size() == groups_max_) return;
  groups_.push_back(bit);
  place(kind + 1, alone_so_far);
  groups_.pop_back();
}

void AllPartitions::weigh(PlanCost alone_so_far) {
  PlanCost cost = alone_so_far;
  for (const std::size_t group : groups_) cost = cost + together_[group];
  const double judged = (*judge_)(cost);
  if (judged >= least_) return;
  least_ = judged;
  best_ = groups_;
}

}  // namespace sft::udp
