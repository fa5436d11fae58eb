// The receiving thread: datagrams in, samples into the inboxes of the readers that asked for them.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "udp_transport/datagram_io.h"
#include "udp_transport/reassembly.h"
#include "udp_transport/receive_shares.h"
#include "udp_transport/subscriptions.h"

namespace sft::udp {

/// Its thread keeps it alive, so that a listener may destroy the transport that calls it.
class Receiver final : private DatagramSink, public std::enable_shared_from_this<Receiver> {
 public:
  /// What this half says to the one that sends, and hears for it. Called by the receiving thread.
  struct Acks {
    std::function<void(const Ack&)> hear;
    Reassembly::SendAck send;
    std::function<void(const FlowReport&, std::chrono::steady_clock::time_point)> hear_report;
    std::function<void(const SocketAddress&, const FlowReport&)> report;
  };
  /// `receive_buffer_bytes` of the socket are shared by all who send to it.
  Receiver(std::unique_ptr<DatagramReceiver> io, const ReassemblyLimits& limits,
           std::size_t receive_buffer_bytes, std::shared_ptr<core::BufferPool> pool, Acks acks);

  Result<void> start(const std::string& thread_name);
  /// Afterwards nothing is received. Called by a listener, it takes effect once that has returned.
  void stop();

  SubscriptionDirectory& subscriptions() { return subscriptions_; }
  core::Transport::Counters counters() const noexcept;
  /// The system gave up on the socket.
  bool broken() const noexcept { return broken_.load(std::memory_order_relaxed); }

 private:
  void run();
  void begin(ArrivalTime now) noexcept override;
  void datagram(std::span<const std::byte> bytes, SocketAddress from) noexcept override;
  void end() noexcept override;
  Reassembly::Arrival accept(std::span<const std::byte> bytes) noexcept;
  void enter();
  void hear_ack(std::span<const std::byte> bytes) noexcept;
  void hear_report(std::span<const std::byte> bytes) noexcept;
  void report(std::span<const std::byte> mark, SocketAddress from) noexcept;
  Reassembly::Arrival accept_heartbeat(std::span<const std::byte> bytes, SocketAddress from) noexcept;
  void deliver(Reassembly::Arrival arrival);
  void deliver_in_order(core::EndpointId writer);
  bool deliver_next(core::EndpointId writer);
  void answer(std::chrono::steady_clock::time_point now) noexcept;
  std::chrono::steady_clock::time_point next_deadline() const;
  void publish_counters() noexcept;

  std::unique_ptr<DatagramReceiver> io_;
  SubscriptionDirectory subscriptions_;
  std::thread thread_;
  std::atomic<bool> stopping_{false};
  std::atomic<bool> broken_{false};
  std::atomic<std::uint64_t> malformed_{0}, unknown_{0}, incomplete_{0}, over_limit_{0};

  // Of the receiving thread alone.
  const Acks acks_;
  std::uint64_t malformed_acks_ = 0;
  ReceiveShares shares_;
  Reassembly reassembly_;
  std::shared_ptr<const Subscriptions> wanted_;
  ArrivalTime now_;
};

}  // namespace sft::udp
