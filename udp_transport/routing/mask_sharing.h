// Decides which processes get one copy of each sample for all their readers, instead of one copy for each of
// their selections (multicast.md). This also works without multicast. Uses no clock, thread or I/O. Must be
// used by the agent's thread only.
#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <vector>

#include "sft/selection.h"
#include "udp_transport/multicast/body_sizes.h"
#include "udp_transport/multicast/plan_cost.h"
#include "udp_transport/routing/route_bundle.h"

namespace sft::udp {

class MaskSharing {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// The readers of a process begin to share one copy if their separate copies together have `wire_max`
  /// times its bytes (PlanLimits). They stop sharing when half of that surplus is gone.
  explicit MaskSharing(const PlanLimits& limits) : limits_(limits) {}

  /// Notes the requests of the readers at each destination. Omits destinations with a reader that does not
  /// get exactly the published samples. Such a reader has a maximum rate, conditions or retained samples, or
  /// is served through shared memory.
  void look_at(const std::vector<RouteBundle>& routes);
  /// Returns true if some destination has readers with different selections. Then the sizes of samples have
  /// to be measured.
  bool is_possible() const { return !several_.empty(); }

  /// Decides again for destinations with new selections, and for all destinations once in each `pause`.
  /// Returns true if a decision has changed. If the size of some field is not known yet, the former
  /// decision stays in force, and the next sample is measured.
  bool decide(BodySizes& sizes, Time now);
  /// Returns true if selections have changed, and decide() can make a decision about them now.
  bool is_undecided(const BodySizes& sizes) const;
  bool shares(const Destination* to) const;

  /// Returns the number of bytes on the wire of one sample to a destination with these selections. `asked`
  /// has one or several selections.
  double bytes_to(const Destination* to, const std::vector<Selection>& asked, PlaceMark place,
                  const BodySizes& sizes) const;
  /// For each destination that shares one copy and is in no multicast group, merges its bundles into one.
  void merge(std::vector<RouteBundle>& routes) const;

 private:
  struct Place {
    std::vector<Selection> asked{};
    Selection together{};  ///< one_copy() for all of `asked`
    PlaceMark mark = PlaceMark::none;
    std::size_t datagram_bytes = 0;
    bool is_decided = false;
    bool shares = false;
  };

  bool is_better_shared(const Place& place, const BodySizes& sizes) const;

  static constexpr std::chrono::seconds pause{1};

  const PlanLimits limits_;
  std::map<const Destination*, Place> several_;  ///< destinations with several selections
  Time next_look_{};
};

}  // namespace sft::udp
