// Maintains the multicast groups of one writer. It decides by a cost model which groups the writer should
// have, and makes them (multicast.md). Must be used by the agent's thread only, except for why().
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "udp_transport/io/multicast_links.h"
#include "udp_transport/multicast/body_sizes.h"
#include "udp_transport/multicast/multicast_group.h"
#include "udp_transport/multicast/multicast_plan.h"
#include "udp_transport/multicast/sample_rate.h"
#include "udp_transport/routing/farewells.h"
#include "udp_transport/routing/group_reasons.h"
#include "udp_transport/routing/mask_sharing.h"
#include "udp_transport/routing/pass_rates.h"
#include "udp_transport/routing/route_bundle.h"
#include "udp_transport/routing/settling_times.h"

namespace sft::udp {

class GroupKeeper {
 public:
  using Time = GroupMembership::Time;
  /// Makes the destination for a group on the link where this host has the address `own`. Datagrams have at
  /// most `datagram_bytes` bytes.
  using Connect = std::function<std::shared_ptr<Destination>(std::uint32_t group, std::uint32_t own,
                                                             std::size_t datagram_bytes)>;
  struct Setup {
    std::uint32_t writer = 0;
    const TypeSupport* type = nullptr;  ///< must outlive this object
    Multicast use = Multicast::automatic;
    std::uint16_t report_port = 0;
    std::size_t queue_depth = 4;
    std::shared_ptr<WriterTally> tally;
    GroupRegistry* registry = nullptr;  ///< must outlive this object
    Connect connect;
    PlanLimits limits{};
    /// Returns the present links of this host.
    std::function<std::vector<MulticastLink>(Multicast)> links = multicast_links;
  };
  explicit GroupKeeper(Setup setup);

  // The following functions are called in this order when routes are made anew:

  /// Merges the bundles of each group's members into one bundle. A destination that is new, or has changed
  /// its request, gets its own copies until it counts as settled (SettlingTimes). Readers of one process may
  /// share a copy, too.
  void merge(std::vector<RouteBundle>& routes, Time now);
  /// Returns the group that is at `place` in the plan with these members. Makes it if it does not exist.
  std::shared_ptr<MulticastGroup> find(std::size_t place, std::vector<MulticastGroup::Member> members);
  void merged(Time now);

  /// Returns the object that measures the sizes of samples; null if no sizes have to be measured, because no
  /// destination can be in a group.
  const std::shared_ptr<BodySizes>& sizes() const { return sizes_; }

  /// Makes a new plan if it is time. Returns true if other groups are better. Then routes have to be made
  /// anew.
  bool replan(Time now);
  /// Sends the offers, probes and farewells that are due.
  void maintain(Time now);
  /// Returns the time by which replan() or maintain() should be called; Time::max(): at no certain time.
  Time next_duty(Time now) const;

  /// Returns a text that names the multicast group of a reader, or the reason why the reader is in no group.
  /// Any thread may call this.
  std::string why(core::EndpointId reader) const { return reasons_.of(reader); }

 private:
  struct Candidate {
    std::shared_ptr<Destination> to;
    std::vector<Selection> asked{};
    Selection together{};  ///< one_copy() for all of `asked`
    /// The union of the requests of all readers at the destination; empty if every sample is for these
    /// readers. The requests have a maximum rate or conditions.
    std::optional<core::Wanted> some_samples{};
    /// The gate that selects the samples for these readers; null: every sample is for them.
    std::shared_ptr<const core::Gate> gate{};
    bool reliable = false;
    bool gets_more = false;             ///< true if the destination needs samples that the group does not get
    Time settled_at{};                  ///< until this time, the destination is in no group
    std::optional<std::size_t> link{};  ///< index in `links_`; empty: the destination cannot be in a group
    std::string refusal{};              ///< why the destination cannot be in a group
    std::size_t division = 0;           ///< number of the destination's division (divide())
  };
  struct Planned {
    std::size_t place = 0;                       ///< index of the group, which determines its address
    std::optional<core::Wanted> some_samples{};  ///< the members' requests, as in Candidate
    std::vector<const Destination*> members{};
  };
  /// The destinations and the rate for which the present plan was made.
  struct PlannedFor {
    std::map<const Destination*, PlanDestination> destinations{};
    double samples_per_s = 0;
    bool member_left = false;  ///< true if a member has left since the plan was made
  };

  /// Measured values of samples. They are kept even if no group needs them at present.
  struct Measured {
    std::shared_ptr<BodySizes> sizes{};
    std::optional<SampleRate> rate{};  ///< the rate of samples; empty until samples are measured
    PassRates passing{};
  };

  void look_at(const std::vector<RouteBundle>& routes, Time now);
  void look_at(const RouteBundle& bundle, Time now);
  void await_settled(Time now);
  static bool is_settled(const Candidate& candidate, Time now) {
    return candidate.refusal.empty() && now >= candidate.settled_at;
  }
  bool any_given_up(Time now);
  std::size_t possible(Time now) const;
  void choose_link(Candidate& candidate, Time now) const;
  void choose_sizes(Time now);
  void keep_possible(Time now);
  void merge(const Planned& planned, std::vector<RouteBundle>& routes) const;
  bool plan(Time now);
  bool may_plan(Time now) const;
  bool member_came(Time now) const;
  void hasten(Time now);
  std::vector<PlanDestination> plan_destinations(std::vector<const Destination*>& places, Time now);
  bool is_planned(const Destination* to, const Candidate& candidate) const;
  bool is_news(std::span<const Destination* const> places, std::span<const PlanDestination> all) const;
  std::uint32_t address(std::size_t place) const;
  static void send(Destination& to, const GroupOffer& offer, Time now);
  static void send(MulticastGroup& to, const GroupProbe& probe);
  void explain(const std::vector<RouteBundle>& routes, Time now);

  /// The minimum time between two plans. Several readers often come at the same time, so one plan is made
  /// for them.
  static constexpr std::chrono::milliseconds settling{50};
  static constexpr std::chrono::seconds replan_pause{1};
  static constexpr std::chrono::minutes unreached_pause{
      1};  ///< pause before the group is offered again to a member that received nothing
  /// The time without groups after several samples were published by one call.
  static constexpr std::chrono::seconds packed_pause{10};

  const Setup setup_;
  /// True if the type has so many leaves that only hashes of its masks are sent, and not their words.
  const bool too_many_leaves_;
  std::vector<MulticastLink> links_;
  std::map<const Destination*, Candidate> candidates_;
  SettlingTimes settling_times_;
  MaskSharing sharing_;
  Measured measured_;
  std::shared_ptr<BodySizes> sizes_;  ///< `measured_.sizes`; null while sizes are not needed
  PlannedFor planned_for_;
  std::vector<Planned> planned_;
  std::vector<std::shared_ptr<MulticastGroup>> groups_, found_;
  Farewells farewells_;
  std::map<const Destination*, Time> unreached_until_;
  Time packed_until_{};
  std::uint32_t last_number_ = 0;
  Time replan_at_{};
  Time planned_at_{};  ///< time of the last change of the plan
  GroupReasons reasons_;
};

}  // namespace sft::udp
