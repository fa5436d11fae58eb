// The channels that the sending thread maintains. The class sends their samples, repairs and heartbeats.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "udp_transport/send/flow_sender.h"
#include "udp_transport/send/next_round.h"
#include "udp_transport/send/send_flow.h"

namespace sft::udp {

/// All functions must be called by the sending thread.
class ChannelFlows {
 public:
  /// Both arguments must outlive this object.
  ChannelFlows(FlowSender& sender, NextRound& round) : sender_(sender), round_(round) {}

  void add(std::shared_ptr<Channel> channel);
  /// Sends the small samples and the heartbeats that are due.
  void send_small();
  /// Sends a part of a large sample of one channel. `which` is the index of the channel, less than count().
  void send_large(std::size_t which);
  std::size_t count() const { return attended_.size(); }
  int priority(std::size_t which) const {
    return attended_[which].channel ? attended_[which].channel->tally().priority : 0;
  }
  /// Removes the channels that need no maintenance until their next sample.
  void forget_resting();
  void clear() { attended_.clear(); }

 private:
  struct Attended {
    std::shared_ptr<Channel> channel;  ///< the channel; null: the entry is removed at the end of the round
    SendFlow small, large;
  };
  void advance(SendFlow& flow);
  void look_after(Attended& attended);
  void send(const Heartbeat& heartbeat, const Attended& attended);

  FlowSender& sender_;
  NextRound& round_;
  std::vector<Attended> attended_;
};

}  // namespace sft::udp
