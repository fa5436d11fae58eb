// Looks for a cheap way to put the destinations of one division into groups, without trying all of them
// (multicast.md).
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "udp_transport/multicast/plan_cost.h"

namespace sft::udp {

/// Destinations that are treated alike. (To split them would only ever pay where one of them gives a group
/// its second member, so that another one gets its several masks at once.)
struct PlanKind {
  Selection fields;
  double alone_bytes = 0;  ///< of each
  std::size_t datagram_bytes = 0;
  std::size_t destinations = 1;
};

class PlanSearch {
 public:
  /// Where a kind is: the number of its group.
  static constexpr std::size_t alone = SIZE_MAX;
  static constexpr std::size_t exact_max = 8;
  using Places = std::vector<std::size_t>;

  /// All three outlive it.
  PlanSearch(std::span<const PlanKind> kinds, const BodyBytes& body_bytes, const PlanLimits& limits);

  /// The places after each kind of `newcomers` went to the best place, while the others stay.
  Places insert(const Places& places, std::span<const std::size_t> newcomers);
  /// The best places of at most `exact_max` kinds; of more, the best ones that look_from() finds.
  Places search(const Places& present);
  /// The best places that are found from several beginnings, of which one is `present`.
  Places look_from(const Places& present);

  PlanCost cost_of(const Places& places);
  /// False: more bytes are on the wire than may be.
  bool allows(PlanCost cost) const { return cost.wire <= wire_max_; }

 private:
  struct Group {
    std::vector<std::size_t> kinds{};
    Selection fields{};
    std::size_t datagram_bytes = SIZE_MAX;
    std::size_t destinations = 0;
    double together = 0;  ///< bytes of one copy under `fields`
    PlanCost cost{};
  };

  Group with(const Group& group, std::size_t kind) const;
  Group without(const Group& group, std::size_t kind) const;
  Group united(Group group, const Group& other) const;
  void weigh(Group& group, double known_together) const;
  PlanCost alone_cost(std::size_t kind) const;
  double judge(PlanCost cost) const;

  void begin(const Places& places);
  void remove(std::size_t kind);
  bool settle(std::size_t kind);
  bool move_one_by_one();
  bool dissolve_groups();
  bool unite_groups();
  bool pair_up();
  void improve();
  Places try_all() const;
  Places cut_by_size() const;
  void improve_from(const Places& places);
  Places seeded(std::span<const std::size_t> order);
  void keep_if_best();

  static constexpr std::size_t partners_max = 12;  ///< that one kind is paired with in turn

  const std::span<const PlanKind> kinds_;
  const BodyBytes& body_bytes_;
  const PlanLimits limits_;
  std::vector<std::size_t> by_size_;  ///< kinds, the largest first
  double wire_max_ = 0;

  // The partition that is worked on, and the best one so far.
  Places places_, best_;
  std::vector<Group> groups_;
  PlanCost cost_{};
  double best_judged_ = 0;
  double excess_weight_ = 0;  ///< see judge()
};

}  // namespace sft::udp
