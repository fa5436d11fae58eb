// A remote socket that samples are sent to, and the path to it. All writers that serve readers behind the
// socket share it. The path can change, since a socket has several addresses. At each address the socket has
// to answer before it is sent more than a few datagrams (flow_window.h).
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

  /// `flow` is the number by which the receiver names this host; nobody else can guess it. `connect` is
  /// called again for the first large sample. Channels to this socket are numbered from `channels` on, which
  /// nobody else can guess either. `host` is the budget of the address, see FlowWindow.
  Destination(const SocketAddress& address, const DestinationLimits& limits, std::uint32_t flow,
              Connect connect, std::uint32_t channels = 0, std::shared_ptr<UnprovenBudget> host = {});

  // Any thread.

  std::uint32_t flow() const { return flow_; }
  /// The channel of that number, which counts the channels of a writer, is called by this there.
  std::uint32_t name_of_channel(std::uint32_t number) const { return channels_ + number; }

  /// Answers questions about the address, and about the length of datagrams.
  const RemotePath& path() const { return path_; }
  /// Answers questions about how much may be under way.
  const SharedFlowWindow& window() const { return window_; }

  /// The connection for what is small, and must not queue behind large samples.
  Connection& connection() { return connections_.small(); }
  /// Returns the connection for datagrams that must not overtake anything that was sent up to `position`.
  Connection& connection_after(std::uint64_t position);
  /// The connection for large samples; null before the first.
  Connection* bulk_in_use() { return connections_.bulk_in_use(); }
  std::size_t datagrams_per_call() const { return connections_.datagrams_per_call(); }

  /// The size of the remote socket's receive buffer as announced.
  void set_receive_buffer(std::uint32_t bytes) { window_.announce(bytes); }
  std::size_t room(Size size, Time now) { return window_.room(size, now); }
  /// Returns true if a heartbeat or an offer may go. What may not is withheld until the receiver reports, for
  /// which it is asked here: it may be all that is left to send.
  bool takes_control(Time now);
  /// Notes what was sent through one of the connections; `longest` is the length of the longest datagram.
  /// Sends the receiver a mark if one is due.
  void sent(const Connection& by, std::size_t bytes, std::size_t datagrams, std::size_t longest, Time now);
  /// Somebody waits for room: asks a receiver again that does not report.
  void mark(Time now);
  /// Learns from a send that was refused; the next one fits, and takes the way as it is now.
  void note(SendOutcome outcome) noexcept;

  /// A report that repeats one of our marks shows that the receiver is at the address that it comes from.
  [[nodiscard]] Heard hear(const FlowReport& report, const core::IpAddress& from, Time now);
  /// An ack of one of its channels came.
  void lives(Time now) { window_.lives(now); }
  /// The host there says that nobody has that port.
  void refused(Time now) { window_.refused(now); }
  /// An ack asks for something again: it is asked soon whether long datagrams arrive.
  void asked_again() { window_.asked_again(); }

  /// Moves to another address of the same socket; datagrams on their way go on.
  void move_to(const SocketAddress& address, std::shared_ptr<UnprovenBudget> host) noexcept;
  /// Counts these moves, and the returns of a receiver that was silent: what it is told again, it is told at
  /// once.
  std::uint32_t moves() const { return moves_.load(std::memory_order_relaxed); }

  // The sending thread.

  /// The connection for large samples. The first call makes it.
  Connection& bulk() { return connections_.bulk(path_); }

  // The thread that looks after all destinations.

  /// Called from time to time: the path may take longer datagrams by now. `anew`: it may be another one.
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
  // Used by the thread that looks after the destination.
  Time kernel_asked_at_{};
  bool was_limited_ = false;  ///< at the last call of take_limit_change()
};

}  // namespace sft::udp
