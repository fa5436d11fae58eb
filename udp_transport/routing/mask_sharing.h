// Decides which processes are sent one copy of a sample that serves all their readers, instead of one copy
// for each of them (multicast.md). That needs no multicast.
// Pure: what is asked for, sizes and times go in, decisions come out. Of the agent's thread.
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

  /// Readers share one copy if all copies together have `wire_max` times its bytes. They go on until half of
  /// that surplus is gone.
  explicit MaskSharing(const PlanLimits& limits) : limits_(limits) {}

  /// Notes what the readers of each destination ask for. Leaves out destinations with a reader that is sent
  /// something else than each sample: one with a maximum rate, with conditions, with retained samples, or in
  /// shared memory.
  void look_at(const std::vector<RouteBundle>& routes);
  /// True if some destination is sent several copies: it matters how large these are.
  bool is_possible() const { return !several_.empty(); }

  /// Decides anew where selections have changed, and everywhere once in `pause`. True if a decision has
  /// changed. Where the size of some field is not known yet, the former decision holds, and the next sample
  /// is measured.
  bool decide(BodySizes& sizes, Time now);
  /// True if decide() would decide on selections that have changed.
  bool is_undecided(const BodySizes& sizes) const;
  bool shares(const Destination* to) const;

  /// Bytes on the wire of one sample to a destination that asks for these, which need not be several.
  double bytes_to(const Destination* to, const std::vector<Selection>& asked, PlaceMark place,
                  const BodySizes& sizes) const;
  /// Puts the bundles of each destination that shares one copy, and is in no multicast group, into one.
  void merge(std::vector<RouteBundle>& routes) const;

 private:
  struct Place {
    std::vector<Selection> asked{};
    Selection together{};  ///< one_copy() for all of them
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
