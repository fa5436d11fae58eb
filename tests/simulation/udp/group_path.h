// The path by which a multicast group connects the writer with the process of the readers. Other members of
// the group are not simulated. The channel repairs losses of the group.
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
  /// The arguments must outlive this object.
  GroupPath(Random& random, Network& network, ChannelSender& channel, Laws& laws)
      : random_(random), network_(network), channel_(channel), laws_(laws) {}

  /// Returns true if the process is in a group.
  bool exists() const { return group_.has_value(); }
  /// Takes the process out of its group until the next change().
  void leave() { group_.reset(); }
  /// Moves the process to another group or to none, or changes whether datagrams of the present group reach
  /// the process.
  void change();
  /// Called when the process has crashed and was started again. If it was in a group, it joins another one.
  void begin_anew();

  /// Gives the sample a place in the channel and in the group. The sample is sent soon.
  void send(const udp::JobHandle& job, Time now);
  /// Sends the samples that are due.
  void send_due(Time now);
  /// Offers the group to the process, and sends a probe to the group, if either is due.
  void offer(Time now);
  void hear(const udp::GroupReport& report, Time now);
  /// Returns the time at which the next sample is sent.
  Time next() const { return leaving_.empty() ? Time::max() : leaving_.front().at; }

 private:
  struct Group {
    std::uint32_t number = 0;
    bool is_cut = false;                  ///< whether the group's datagrams fail to reach the process
    std::uint64_t last_ordinal = 1;       ///< the ordinal of the last sample, which probes carry
    std::optional<std::int64_t> ahead{};  ///< the ordinal of a sample in the channel minus that in the group
    udp::GroupMembership membership{};
    udp::ProbeSchedule probes{};
  };
  /// A sample that waits to be sent to a group, which need not be the present group.
  struct Leaving {
    Time at;
    udp::JobHandle job;
    /// The sample's ordinal in the channel; 0 if the channel sends the sample, too.
    std::uint64_t in_channel = 0;
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
  std::deque<Leaving> leaving_;  ///< waiting samples, the oldest first
};

}  // namespace sft::simulation
