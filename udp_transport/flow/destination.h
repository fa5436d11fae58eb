// A remote socket to which samples are sent, and the path to it. All writers that serve readers of that
// socket share one Destination. The path can change, since a socket has several addresses. At each new
// address, only a few datagrams are sent until the socket answers (flow_window.h).
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

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
  /// Our port, to which receivers send reports; 0: receivers are not asked for reports.
  std::uint16_t report_port = 0;
  FlowLimits flow{};
};

class Destination {
 public:
  using Time = FlowWindow::Time;
  using Size = FlowWindow::Size;
  using Heard = SharedFlowWindow::Heard;

  /// `flow` is the number by which reports of the receiver name this destination. `connect` is called again
  /// for the first large sample. Channels to this socket are numbered from `channels` on. Other processes
  /// must not be able to guess `flow` and `channels`. `host` is the budget of the remote host (FlowWindow).
  Destination(const SocketAddress& address, const DestinationLimits& limits, std::uint32_t flow,
              Connect connect, std::uint32_t channels = 0, std::shared_ptr<UnprovenBudget> host = {});

  // Any thread may call the following functions.

  std::uint32_t flow() const { return flow_; }
  /// Returns the number by which datagrams to this socket name the writer's channel `number`.
  std::uint32_t name_of_channel(std::uint32_t number) const { return channels_ + number; }

  /// Returns the address of the socket, and the length of datagrams on the path.
  const RemotePath& path() const { return path_; }
  /// Returns the window that limits the bytes under way.
  const SharedFlowWindow& window() const { return window_; }

  /// Returns the connection for small samples and control, which must not wait until large samples have
  /// left.
  Connection& connection() { return connections_.small(); }
  /// Returns a connection for datagrams that must not overtake the datagrams that were sent up to
  /// `position`.
  Connection& connection_after(std::uint64_t position);
  /// Returns the connection for large samples; null until the first large sample is sent.
  Connection* bulk_in_use() { return connections_.bulk_in_use(); }
  std::size_t datagrams_per_call() const { return connections_.datagrams_per_call(); }

  /// Sets the size of the remote socket's receive buffer as its node announced it.
  void set_receive_buffer(std::uint32_t bytes) { window_.announce(bytes); }
  std::size_t room(Size size, Time now) { return window_.room(size, now); }
  /// Returns true if a heartbeat or an offer may be sent. If not, it is withheld until the receiver reports.
  /// The function then sends the receiver a flow mark if one is due, since no other datagram may be left to
  /// send.
  bool takes_control(Time now);
  /// Notes what was sent through the connection `by`, and sends the receiver a flow mark if one is due.
  /// `longest` is the length of the longest datagram in bytes.
  void sent(const Connection& by, std::size_t bytes, std::size_t datagrams, std::size_t longest, Time now);
  /// Called while a sender waits for room in the window. Sends another flow mark if the receiver has not
  /// reported and a mark is due.
  void mark(Time now);
  /// Adapts the path to the outcome of a failed send, so that the next send uses the present route and a
  /// length of datagrams that fits.
  void note(SendOutcome outcome) noexcept;

  /// Processes a report that came from the address `from`. If the report repeats one of our flow marks, the
  /// receiver is at that address.
  [[nodiscard]] Heard hear(const FlowReport& report, const core::IpAddress& from, Time now);
  /// Notes that an ack for one of the channels to this socket came, which shows that the receiver lives.
  void lives(Time now) { window_.lives(now); }
  /// Notes that the remote host has reported that no socket has that port (ICMP).
  void refused(Time now) { window_.refused(now); }
  /// Notes that an ack requests data again. A flow mark is then sent soon, to find out if long datagrams
  /// arrive.
  void asked_again() { window_.asked_again(); }

  /// Sends to another address of the same socket from now on. Datagrams that are under way still count in
  /// the window.
  void move_to(const SocketAddress& address, std::shared_ptr<UnprovenBudget> host) noexcept;
  /// Returns the number of moves to another address plus the number of times that a silent receiver has
  /// answered again. After each of these events, heartbeats and offers are due at once, so callers compare
  /// the number.
  std::uint32_t moves() const { return moves_.load(std::memory_order_relaxed); }

  // The following functions are for the sending thread only.

  /// Returns the connection for large samples. The first call makes it.
  Connection& bulk() { return connections_.bulk(path_); }

  // The following functions are for the thread that maintains all destinations.

  /// Called regularly. Tries longer datagrams if the pause of that search is over, and asks the kernel about
  /// the path every few seconds. `anew` is true if routes or our own addresses have changed.
  void look_after(Time now, bool anew) noexcept;
  enum class Change : std::uint8_t { none, found, over };
  /// Returns whether a limit of the length of datagrams was found, or has ended, since the last call.
  Change take_limit_change() noexcept;
  /// Returns whether the receiver has not answered for `silence_named_after` by now, or answers again, since
  /// the last call.
  Change take_silence_change(Time now) noexcept;
  /// A receiver that has ended is forgotten sooner than this, since its process gives no heartbeats.
  static constexpr std::chrono::seconds silence_named_after{10};

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
  // The following members are used by the thread that maintains the destinations.
  Time kernel_asked_at_{};
  bool was_limited_ = false;  ///< true if a limit was known at the last call of take_limit_change()
  bool was_silent_ = false;   ///< true if the last call of take_silence_change() has found that silence
  std::optional<Time> mute_since_{};
};

}  // namespace sft::udp
