// The sending thread sends the samples that publishers have queued, as fast as each destination accepts
// them. No destination waits for another: if the send buffer of one connection is full, the thread continues
// with the other ones. Small samples are sent before large ones. Large samples of one priority take turns.
// Flows to one destination share what it accepts, so those with a greater priority, which come first in each
// round, leave to the others only what they do not need.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <thread>
#include <utility>
#include <vector>

#include "core/platform/thread.h"
#include "udp_transport/flow/rate_limit.h"
#include "udp_transport/io/datagram_io.h"
#include "udp_transport/outgoing/wake.h"
#include "udp_transport/send/channel_flows.h"
#include "udp_transport/send/flow_sender.h"
#include "udp_transport/send/lane_flows.h"
#include "udp_transport/send/local_turns.h"
#include "udp_transport/send/next_round.h"
#include "udp_transport/send/scheduled_work.h"

namespace sft::udp {

class Sender {
 public:
  /// Sends at most `max_bytes_per_s`; 0: no limit.
  explicit Sender(std::unique_ptr<DatagramSender> io, std::uint64_t max_bytes_per_s = 0);
  ~Sender();
  Sender(const Sender&) = delete;
  Sender& operator=(const Sender&) = delete;

  /// The function, like hear_answer(), that handles an answer which came to answer_port(). It is called on
  /// the sending thread.
  using Hear = FlowSender::Hear;
  Result<void> start(const core::ThreadSpec& thread, Hear hear = {});
  /// Ends the thread. Queued samples are not sent any more. Must not be called by the sending thread.
  void stop();
  bool stopped() const { return stopped_.load(std::memory_order_acquire); }

  // Any thread may call the following functions.

  std::unique_ptr<Connection> connect(const SocketAddress& to) { return io_->connect(to); }
  /// Sends one datagram without a connection. The datagram is dropped if it cannot be sent at once.
  void send_to(const SocketAddress& to, std::span<const std::byte> datagram) noexcept {
    io_->send_to(to, datagram);
  }
  /// Returns the common rate limit of all writers.
  RateLimit& limit() { return limit_; }
  LocalTurns& local_turns() { return local_turns_; }
  /// Returns the port to which answers come; 0: there is no separate port for answers.
  std::uint16_t answer_port() const { return io_->answer_port(); }
  std::unique_ptr<Connection> connect_group(const SocketAddress& group, const SocketAddress& own) {
    return io_->connect_group(group, own);
  }
  /// Adds a lane, a channel or deferred work, and wakes the sending thread (ScheduledWork). Called when an
  /// idle lane gets a job, a channel at rest gets data to send, or work is deferred.
  template <class One>
  void schedule(std::shared_ptr<One> one) {
    scheduled_.add(std::move(one));
  }
  /// Makes the sending thread check all lanes and channels at once. Called when lanes were closed, or
  /// channels have data to send.
  void look_again() noexcept { io_->wake(); }
  /// Wakes the sending thread for a lane, a channel or deferred work, if `wake` requires that.
  template <class One>
  void wake(Wake wake, const std::shared_ptr<One>& one) {
    if (wake == Wake::schedule) return schedule(one);
    if (wake == Wake::look) look_again();
  }
  /// Wakes the sending thread if `wake` requires that. Used if there is no lane, channel or deferred work to
  /// schedule.
  void wake(Wake wake) noexcept {
    if (wake != Wake::none) look_again();
  }

 private:
  void run();
  void take_over_scheduled();
  void send_large();
  int priority(std::size_t flow) const;

  const std::unique_ptr<DatagramSender> io_;
  RateLimit limit_;
  LocalTurns local_turns_;
  ScheduledWork scheduled_;
  std::thread thread_;
  std::atomic<bool> stopped_{false};

  // The following members are used by the sending thread only.
  NextRound round_;
  FlowSender flow_sender_;
  LaneFlows lanes_;
  ChannelFlows channels_;
  ScheduledWork::Taken taken_;
  std::size_t turn_ = 0;            ///< determines which large flow has the first turn in a round
  std::vector<std::size_t> order_;  ///< the large flows of a round in the order of their turns
};

}  // namespace sft::udp
