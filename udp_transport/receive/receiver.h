// Datagrams in, samples into the inboxes of the readers that asked for them: by a thread of its own, or by
// one that waits for a sample (receiving_role.h).
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "core/platform/thread.h"
#include "udp_transport/flow/receive_shares.h"
#include "udp_transport/io/datagram_io.h"
#include "udp_transport/io/group_joins.h"
#include "udp_transport/io/udp_socket.h"
#include "udp_transport/receive/lag_watch.h"
#include "udp_transport/receive/reassembly.h"
#include "udp_transport/receive/receiving_role.h"
#include "udp_transport/receive/spin_choice.h"
#include "udp_transport/receive/subscriptions.h"

namespace sft::udp {

/// Its thread keeps it alive, so that a listener may destroy the transport that calls it. "The receiving
/// thread" is whichever has the role.
class Receiver final : private DatagramSink, public std::enable_shared_from_this<Receiver> {
 public:
  /// What this half says to those who send, and hears for its own other half. Called by the receiving thread.
  struct Acks {
    std::function<void(std::span<const std::byte> answer, const SocketAddress& from,
                       std::chrono::steady_clock::time_point)>
        hear;
    Reassembly::SendAck send;
    std::function<void(const SocketAddress&, const FlowReport&)> report;
  };
  /// And what multicast groups need.
  struct Groups {
    Reassembly::SendReport send;
    std::shared_ptr<GroupJoins> joins;
  };
  /// `receive_buffer_bytes` of the socket are shared by all who send to it.
  Receiver(std::unique_ptr<DatagramReceiver> io, const ReassemblyLimits& limits,
           std::size_t receive_buffer_bytes, std::shared_ptr<core::BufferPool> pool, Acks acks,
           Groups groups);

  Result<void> start(const core::ThreadSpec& thread);
  /// Afterwards nothing is received. Called by a listener, it takes effect once that has returned.
  void stop();

  // Any thread. Of a reader with these wishes; when it returns, no thread but its own calls a listener that
  // is not only waited for.
  void add(const core::ReaderSpec& reader);
  void remove(const core::ReaderSpec& reader);

  /// As ReaderPort::receive(); `who` is the reader.
  bool receive(const void* who, const core::Waiting& waiting) noexcept;
  void interrupt(const void* who) noexcept;

  SubscriptionDirectory& subscriptions() { return subscriptions_; }
  core::Transport::Counters counters() const noexcept;
  /// The system gave up on the socket.
  bool broken() const noexcept { return broken_.load(std::memory_order_relaxed); }

 private:
  using Time = std::chrono::steady_clock::time_point;
  void run();
  void receive_alone();
  void poll(Time until);
  void stand_by(Time until);
  void note_alarm();
  void wait_in_role(const core::Waiting& waiting) noexcept;
  void wait_behind(const core::Waiting& waiting) noexcept;
  void deliver_to_laggards() noexcept;
  bool receive_turn() noexcept;
  void sleep_in_role(Time until) noexcept;
  void look_after_time() noexcept;
  void leave_role() noexcept;
  bool readable() const noexcept;
  void begin(ArrivalTime now) noexcept override;
  void datagram(std::span<const std::byte> bytes, const SocketAddress& from) noexcept override;
  void end() noexcept override;
  Reassembly::Arrival accept(std::span<const std::byte> bytes, const SocketAddress& from) noexcept;
  void enter();
  void report(std::span<const std::byte> mark, SocketAddress from) noexcept;
  void hear_offer(std::span<const std::byte> bytes, SocketAddress from) noexcept;
  Reassembly::Arrival accept_heartbeat(std::span<const std::byte> bytes, SocketAddress from) noexcept;
  void deliver(Reassembly::Arrival& arrival);
  bool deliver_in_order(core::EndpointId writer);
  bool deliver_next(core::EndpointId writer);
  void look_after_readers(Time now);
  void answer(Time now) noexcept;
  Time next_deadline() const;
  void publish_counters() noexcept;

  std::unique_ptr<DatagramReceiver> io_;
  SubscriptionDirectory subscriptions_;
  std::thread thread_;
  ReceivingRole role_;
  FileDescriptor alarm_;         ///< a timerfd: wakes the own thread when a vacancy is over
  FileDescriptor waiter_event_;  ///< wakes the waiting thread that has the role, or is promised it
  std::atomic<const void*> waiter_{nullptr};  ///< its reader
  SpinLimits spins_;
  std::atomic<bool> broken_{false};
  std::atomic<bool> readers_lag_{false};  ///< some had no room for what is there
  std::atomic<std::uint64_t> malformed_{0}, unknown_{0}, incomplete_{0}, over_limit_{0}, disbelieved_{0};

  // Of the own thread.
  SpinChoice spin_choice_;

  // Of the receiving thread alone.
  const Acks acks_;
  const Groups groups_;
  std::uint64_t malformed_marks_ = 0;
  std::uint64_t unknown_marks_ = 0;  ///< of nobody who is read here
  core::IpAddress last_from_;        ///< where the last sample came from
  ReceiveShares shares_;
  Reassembly reassembly_;
  std::shared_ptr<const Subscriptions> wanted_;
  ArrivalTime now_;
  LagWatch lag_watch_;
  std::vector<core::SampleHandle> batch_;  ///< on its way to one inbox
};

}  // namespace sft::udp
