// A remote socket that samples are sent to, and the path to it. All writers that serve readers behind the
// socket share it. The path can change, since a socket has several addresses. At each address the socket
// has to answer before it is sent more than a few datagrams (flow_window.h).
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "core/platform/ip_address.h"
#include "udp_transport/flow/connection_pair.h"
#include "udp_transport/flow/flow_limits.h"
#include "udp_transport/flow/remote_path.h"
#include "udp_transport/flow/shared_flow_window.h"
#include "udp_transport/flow/unproven_budget.h"
#include "udp_transport/io/datagram_io.h"
#include "udp_transport/wire/datagram.h"

namespace sft::udp {

struct DestinationLimits {
  std::size_t datagram_bytes = datagram_bytes_max;
  std::uint16_t report_port = 0;  ///< where receivers report to; 0: they are not asked, and need not answer
  FlowLimits flow{};
};

class Destination {
 public:
  using Time = FlowWindow::Time;
  using Size = FlowWindow::Size;
  using Heard = SharedFlowWindow::Heard;

  /// `flow` is the number by which reports of the receiver name this destination; nobody else can guess it.
  /// `connect` is called again for the first large sample. Channels to this socket are numbered from
  /// `channels` on, which nobody else can guess either. `host` is the budget of the remote host
  /// (FlowWindow).
  Destination(const SocketAddress& address, const DestinationLimits& limits, std::uint32_t flow,
              Connect connect, std::uint32_t channels = 0, std::shared_ptr<UnprovenBudget> host = {});

  // Any thread.

  std::uint32_t flow() const { return flow_; }
  /// Returns the number by which datagrams to this socket name the writer's channel `number`.
  std::uint32_t name_of_channel(std::uint32_t number) const { return channels_ + number; }

  /// The address, and the length of datagrams.
  const RemotePath& path() const { return path_; }
  /// How much may be under way.
  const SharedFlowWindow& window() const { return window_; }

  /// Returns the connection for small samples and control, which must not queue behind large samples.
  Connection& connection() { return connections_.small(); }
  /// Returns the connection for datagrams that must not overtake anything that was sent up to `position`.
  Connection& connection_after(std::uint64_t position);
  /// Returns the connection for large samples; null before the first.
  Connection* bulk_in_use() { return connections_.bulk_in_use(); }
  std::size_t datagrams_per_call() const { return connections_.datagrams_per_call(); }

  /// Sets the size of the remote socket's receive buffer as its node announced it.
  void set_receive_buffer(std::uint32_t bytes) { window_.announce(bytes); }
  std::size_t room(Size size, Time now) { return window_.room(size, now); }
  /// Returns true if a heartbeat or an offer may be sent. If not, it is withheld until the receiver
  /// reports, and the receiver is asked for a report here, since nothing else may be left to send.
  bool takes_control(Time now);
  /// Notes what was sent through one of the connections; `longest` is the length of the longest datagram.
  /// Sends the receiver a mark if one is due.
  void sent(const Connection& by, std::size_t bytes, std::size_t datagrams, std::size_t longest, Time now);
  /// Sends another mark, if one is due, to a receiver that has not reported, because a sender waits for room.
  void mark(Time now);
  /// Adapts to a send that was refused, so that the next one has a length that fits, and uses the present
  /// path.
  void note(SendOutcome outcome) noexcept;

  /// Takes a report. If it repeats one of our marks, the receiver is at the address that it comes from.
  [[nodiscard]] Heard hear(const FlowReport& report, const core::IpAddress& from, Time now);
  /// Notes that an ack of one of the channels to this socket came.
  void lives(Time now) { window_.lives(now); }
  /// Notes that the host there says that no socket has that port (ICMP).
  void refused(Time now) { window_.refused(now); }
  /// Notes that an ack asks for something again. A mark is then sent soon, to find out if long datagrams
  /// arrive.
  void asked_again() { window_.asked_again(); }

  /// Moves to another address of the same socket. Datagrams that are under way still count.
  void move_to(const SocketAddress& address, std::shared_ptr<UnprovenBudget> host) noexcept;
  /// Returns the number of these moves, and of the returns of a receiver that was silent. After each of
  /// them, heartbeats and offers are due at once.
  std::uint32_t moves() const { return moves_.load(std::memory_order_relaxed); }

  // The sending thread.

  /// Returns the connection for large samples. The first call makes it.
  Connection& bulk() { return connections_.bulk(path_); }

  // The thread that maintains all destinations.

  /// Tries longer datagrams if it is time, and asks the kernel about the path now and then. `anew`: routes
  /// or our own addresses have changed.
  void look_after(Time now, bool anew) noexcept;
  enum class LimitChange : std::uint8_t { none, found, over };
  /// Returns whether a limit of the length of datagrams was found since the last call, or is over.
  LimitChange take_limit_change() noexcept;

 private:
  static constexpr std::chrono::seconds kernel_is_asked_every{5};

  void learn_from_kernel() noexcept;
  void send(FlowMark mark, Time now);

  const DestinationLimits limits_;
  const std::uint32_t flow_;
  const std::uint32_t channels_;
  RemotePath path_;
  ConnectionPair connections_;
  SharedFlowWindow window_;
  std::atomic<std::uint32_t> moves_{0};
  // Used by the thread that maintains the destinations.
  Time kernel_asked_at_{};
  bool was_limited_ = false;  ///< at the last call of take_limit_change()
};

}  // namespace sft::udp
