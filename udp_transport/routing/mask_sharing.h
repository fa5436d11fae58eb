// Decides which processes get one copy of a sample for all their readers, instead of one copy for each of
// their selections (multicast.md). That needs no multicast. Uses no clock, thread or I/O; used by the
// agent's thread.
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

  /// Readers begin to share one copy if all their copies together have `wire_max` times its bytes. They
  /// stop sharing when half of that surplus is gone.
  explicit MaskSharing(const PlanLimits& limits) : limits_(limits) {}

  /// Notes the requests of the readers at each destination. Leaves out destinations with a reader that does
  /// not get just each sample: a reader with a maximum rate, with conditions, with retained samples, or in
  /// shared memory.
  void look_at(const std::vector<RouteBundle>& routes);
  /// Returns true if some destination is sent several copies, so that their sizes have to be measured.
  bool is_possible() const { return !several_.empty(); }

  /// Decides again for destinations with new selections, and for all destinations once in each `pause`.
  /// Returns true if a decision has changed. If the size of some field is not known yet, the former
  /// decision stays in force, and the next sample is measured.
  bool decide(BodySizes& sizes, Time now);
  /// Returns true if selections have changed, and decide() would make a decision about them now.
  bool is_undecided(const BodySizes& sizes) const;
  bool shares(const Destination* to) const;

  /// Returns the bytes on the wire of one sample to a destination with these selections, of which there may
  /// be one or several.
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
