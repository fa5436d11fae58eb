// The lanes that the sending thread handles. The class sends the jobs of each lane one after another, or
// passes them to the channel of the lane.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "udp_transport/send/flow_sender.h"
#include "udp_transport/send/next_round.h"
#include "udp_transport/send/scheduled_work.h"
#include "udp_transport/send/send_flow.h"

namespace sft::udp {

/// All functions must be called by the sending thread.
class LaneFlows {
 public:
  /// Channels that got jobs are added to `scheduled`. All three arguments must outlive this object.
  LaneFlows(FlowSender& sender, ScheduledWork& scheduled, NextRound& round)
      : sender_(sender), scheduled_(scheduled), round_(round) {}

  void add(std::shared_ptr<Lane> lane) { flows_.emplace_back().lane = std::move(lane); }
  /// Takes the next job of each lane that has no job in progress, and sends the small jobs.
  void send_small();
  /// Sends a part of a large job of one lane. `which` is the index of the lane, less than count().
  void send_large(std::size_t which);
  std::size_t count() const { return flows_.size(); }
  int priority(std::size_t which) const { return flows_[which].lane ? flows_[which].tally().priority : 0; }
  /// Removes the lanes that have become idle.
  void forget_idle();
  void clear() { flows_.clear(); }

 private:
  bool begin(SendFlow& flow);
  bool pass_on(SendFlow& flow);
  void advance(SendFlow& flow);
  void note_stall(SendFlow& flow, std::optional<SendFlow::Time> since);
  const SendFlow* holder_of(const SendFlow& flow);
  bool may_pass(const SendFlow& flow, const SendFlow& other);

  FlowSender& sender_;
  ScheduledWork& scheduled_;
  NextRound& round_;
  std::vector<SendFlow> flows_;  ///< a flow without a lane is removed at the end of the round
};

}  // namespace sft::udp
