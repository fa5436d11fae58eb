// The receiving thread: datagrams in, samples into the inboxes of the readers that asked for them.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "udp_transport/datagram_io.h"
#include "udp_transport/group_socket.h"
#include "udp_transport/reassembly.h"
#include "udp_transport/subscriptions.h"

namespace sft::udp {

/// Its thread keeps it alive, so that a listener may destroy the transport that calls it.
class Receiver final : private DatagramSink, public std::enable_shared_from_this<Receiver> {
 public:
  /// What reliable delivery needs of the half that sends. Called by the receiving thread.
  struct Acks {
    std::function<void(const Ack&)> hear;
    Reassembly::SendAck send;
  };
  /// And what multicast groups need.
  struct Groups {
    std::function<void(const GroupReport&)> hear;
    Reassembly::SendReport send;
    std::shared_ptr<GroupJoins> joins;
  };
  Receiver(std::unique_ptr<DatagramReceiver> io, const ReassemblyLimits& limits,
           std::shared_ptr<core::BufferPool> pool, Acks acks, Groups groups);

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
  void hear_offer(std::span<const std::byte> bytes, SocketAddress from) noexcept;
  void hear_report(std::span<const std::byte> bytes) noexcept;
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
  const Groups groups_;
  std::uint64_t malformed_answers_ = 0;
  Reassembly reassembly_;
  std::shared_ptr<const Subscriptions> wanted_;
  ArrivalTime now_;
};

}  // namespace sft::udp
