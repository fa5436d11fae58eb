// Receives datagrams, in the transport's own thread or in a thread that waits for a sample
// (receiving_role.h).
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <span>
#include <thread>

#include "core/platform/thread.h"
#include "core/sync/spin_choice.h"
#include "udp_transport/io/datagram_io.h"
#include "udp_transport/io/group_joins.h"
#include "udp_transport/io/udp_socket.h"
#include "udp_transport/receive/delivery.h"
#include "udp_transport/receive/demultiplexer.h"
#include "udp_transport/receive/reassembly.h"
#include "udp_transport/receive/receiving_role.h"
#include "udp_transport/receive/spin_limits.h"

namespace sft::udp {

/// The thread keeps its ReceiveLoop alive, so that a listener may destroy the transport that calls it. "The
/// receiving thread" is the thread that has the receiving role.
class ReceiveLoop final : private DatagramSink, public std::enable_shared_from_this<ReceiveLoop> {
 public:
  /// The functions of the sending half of the transport that the loop calls, on the receiving thread.
  struct SendingHalf {
    std::function<void(const Answer&, const SocketAddress& from, std::chrono::steady_clock::time_point)>
        hear_answer;
    SendAck send_ack;
    std::function<void(const SocketAddress&, const FlowReport&)> send_report;
    Reassembly::SendGroupReport send_group_report;
  };
  /// `receive_buffer_bytes` is the size of the socket's receive buffer, which is divided among all senders
  /// to the socket.
  ReceiveLoop(std::unique_ptr<DatagramReceiver> io, const ReassemblyLimits& limits,
              std::size_t receive_buffer_bytes, std::shared_ptr<core::BufferPool> pool,
              SendingHalf sending_half, const std::shared_ptr<GroupJoins>& joins);

  Result<void> start(const core::ThreadSpec& thread);
  /// Ends receiving. After the return, no datagram is received. If a listener calls stop(), that is true
  /// only after the listener has returned.
  void stop();

  // Any thread may call the following functions.

  /// Registers a reader. After the return, only the transport's own thread calls listeners, except if
  /// threads of the reader wait for samples and need no listener.
  void add(const core::ReaderSpec& reader);
  void remove(const core::ReaderSpec& reader);

  /// Implements NetworkReader::receive().
  bool receive(const core::Waiting& waiting) noexcept;
  /// Implements Network::wake_receiver().
  void wake_receiver() noexcept;

  SubscriptionDirectory& subscriptions() { return delivery_.subscriptions(); }
  core::Transport::Counters counters() const noexcept { return published_.load(); }
  struct Health {
    bool is_broken = false;   ///< true if the socket cannot receive any more
    std::string fell_back{};  ///< result of DatagramReceiver::fell_back()
  };
  Health health() const { return {broken_.load(std::memory_order_relaxed), io_->fell_back()}; }

 private:
  using Time = std::chrono::steady_clock::time_point;

  /// The counters of the receiving thread. Any thread can read them.
  class PublishedCounters {
   public:
    void store(const core::Transport::Counters& counters) noexcept;
    core::Transport::Counters load() const noexcept;

   private:
    std::atomic<std::uint64_t> malformed_{0}, unknown_{0}, incomplete_{0}, over_limit_{0}, rejected_{0};
  };

  void run();
  void receive_alone();
  void poll(Time until);
  void stand_by(Time until);
  void give_up();
  void note_alarm();
  void wait_in_role(const core::Waiting& waiting) noexcept;
  void wait_behind(const core::Waiting& waiting) noexcept;
  void deliver_to_laggards() noexcept;
  bool receive_turn() noexcept;
  void end_hand_over() noexcept;
  void sleep_in_role(Time until) noexcept;
  void look_after_time() noexcept;
  void leave_role() noexcept;
  void begin(ArrivalTime now) noexcept override;
  void datagram(std::span<const std::byte> bytes, const SocketAddress& from) noexcept override;
  void end() noexcept override;
  void answer(Time now) noexcept;
  Time next_deadline() const;
  void publish_counters() noexcept;

  std::unique_ptr<DatagramReceiver> io_;
  std::thread thread_;
  ReceivingRole role_;
  /// A timerfd, which wakes the transport's own thread after ReceivingRole::vacancy.
  FileDescriptor alarm_;
  FileDescriptor waiter_event_;  ///< wakes the waiting thread that has the receiving role, or will get it
  SpinLimits spins_;
  std::atomic<bool> broken_{false};
  PublishedCounters published_;

  // Used by the transport's own thread to decide if it polls before it sleeps (spinning). Spinning is useful
  // if the pauses between samples are about as short as the time to wake a thread. For example, a callback
  // that answers at once, and gets the next sample as a reply, is faster with spinning.
  core::SpinChoice spinning_{3};

  // The following members are used by the receiving thread only.
  const SendAck send_ack_;
  const Reassembly::SendGroupReport send_group_report_;
  Reassembly reassembly_;
  Demultiplexer demultiplexer_;
  Delivery delivery_;
  ArrivalTime now_;  ///< time when the present datagrams came
};

}  // namespace sft::udp
