// The writer's way to the process by a multicast group. The group has other members, too, which are not
// simulated. The channel repairs what the group loses.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "tests/simulation/udp/channel_sender.h"
#include "tests/simulation/udp/laws.h"
#include "tests/simulation/udp/network.h"
#include "udp_transport/multicast/group_membership.h"
#include "udp_transport/multicast/probe_schedule.h"

namespace sft::simulation {

class GroupPath {
 public:
  /// The arguments outlive this object.
  GroupPath(Random& random, Network& network, ChannelSender& channel, Laws& laws)
      : random_(random), network_(network), channel_(channel), laws_(laws) {}

  /// True if the process is in a group.
  bool exists() const { return group_.has_value(); }
  /// The process gets into no group until the next change().
  void leave() { group_.reset(); }
  /// The process gets into another group, or into none, or nothing of the group reaches it any more.
  void change();
  /// The process has crashed and was started again. If it was in a group, it gets into another one.
  void begin_anew();

  /// Gives the sample a place in the channel and in the group. It leaves soon.
  void send(const udp::JobHandle& job, Time now);
  /// Sends the samples that have waited long enough.
  void send_due(Time now);
  /// Offers the group to the process, and sends a probe to the group, if it is time to do so.
  void offer(Time now);
  void hear(const udp::GroupReport& report, Time now);
  /// The time when the next sample leaves.
  Time next() const { return leaving_.empty() ? Time::max() : leaving_.front().at; }

 private:
  struct Group {
    std::uint32_t number = 0;
    bool deaf = false;                    ///< nothing of the group reaches the process
    std::uint64_t last_ordinal = 1;       ///< what a probe says before the first sample
    std::optional<std::int64_t> ahead{};  ///< the ordinals of the channel are by so much larger
    udp::GroupMembership membership{};
    udp::ProbeSchedule probes{};
  };
  /// A sample that waits to be sent to a group, which need not be the present group.
  struct Leaving {
    Time at;
    udp::JobHandle job;
    std::uint64_t in_channel = 0;  ///< its ordinal there; 0: the channel sends the sample, too
    bool lost = false;
  };

  void send_now(const udp::JobHandle& job, Time now);
  void probe(Time now);

  Random& random_;
  Network& network_;
  ChannelSender& channel_;
  Laws& laws_;
  std::optional<Group> group_;
  std::uint32_t last_number_ = 0;
  std::deque<Leaving> leaving_;  ///< the oldest first
};

}  // namespace sft::simulation
