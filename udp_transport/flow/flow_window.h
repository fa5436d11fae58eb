// Flow and congestion control towards one remote socket. It limits the bytes under way to what the receiver
// reports that it has room for, and to what the way there carries without a queue that others have to stand
// in.
//
// A receiver has to answer. Before its first report a few small datagrams are sent there, and marks; after a
// second of silence only marks. So nobody can make this host flood another one that did not ask for it.
//
// The class is pure: calls and times go in, decisions come out. All amounts are in bytes as the receiving
// kernel counts them (socket_bytes). Positions count what was sent.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>

#include "udp_transport/flow/congestion_window.h"
#include "udp_transport/flow/delivery_rate.h"
#include "udp_transport/flow/flow_limits.h"
#include "udp_transport/flow/receiver_monitor.h"
#include "udp_transport/flow/round_trips.h"
#include "udp_transport/flow/unproven_allowance.h"
#include "udp_transport/flow/unproven_budget.h"
#include "udp_transport/wire/datagram.h"

namespace sft::udp {

/// Returns how much of a socket's receive buffer datagrams take: the kernel keeps each of them with data of
/// its own.
constexpr std::size_t socket_bytes(std::size_t bytes, std::size_t datagrams) {
  constexpr std::size_t of_each_datagram = 832;
  return bytes + datagrams * of_each_datagram;
}
/// Returns the part of a receive buffer that senders may fill: the kernel gives back what was read in steps
/// of a quarter.
constexpr std::size_t usable_bytes(std::size_t receive_buffer_bytes) { return receive_buffer_bytes / 4 * 3; }

class FlowWindow {
 public:
  using Time = std::chrono::steady_clock::time_point;
  /// Small samples have a part of the window for themselves.
  enum class Size : std::uint8_t { small, large };

  /// `flow` is what the other end calls it by. `secret` hides the times in marks: only who got a mark can
  /// repeat what it says. `host` is what all to that host may send before they are answered; null: no more
  /// than one may.
  FlowWindow(std::uint32_t flow, const FlowLimits& limits, std::uint64_t secret = 0,
             std::shared_ptr<UnprovenBudget> host = {});

  /// Before a report: how large the socket's buffer is.
  void announce(std::size_t receive_buffer_bytes);

  /// Socket bytes that may be sent now. The last datagrams may take more. If there is no room, the sender
  /// waits until hear() or next_ready() says that there is.
  std::size_t room(Size size, Time now);
  /// Somebody waits for more room than there is.
  void await_room() { waiting_ = true; }
  /// Returns true if a heartbeat or an offer may go. It takes no room, apart from the few datagrams of the
  /// beginning.
  bool takes_control(Time now);
  /// The largest batch of which several fit into the window.
  std::size_t batch_bytes() const;
  /// `aside`: sent through another connection than the one that marks go by.
  void sent(std::size_t bytes, std::size_t datagrams, Time now, bool aside = false);

  /// Returns the mark that is due, if any. The caller fills in its port, and sends it through the connection
  /// that was used last. `is_uncertain`: a part of what was sent may not have arrived, so that marks are due
  /// soon.
  std::optional<FlowMark> mark(Time now, bool is_uncertain = false);
  /// Returns true if a report can be the answer to one of our marks.
  bool answers_a_mark(const FlowReport& report) const;
  /// When that mark was sent.
  Time marked_at(const FlowReport& report) const {
    return Time(std::chrono::nanoseconds(hidden(report.sent_at_ns)));
  }
  /// Takes a report of the other end; nonsense is ignored. Returns true if somebody waits who may go on now.
  [[nodiscard]] bool hear(const FlowReport& report, Time now);
  /// Notes an authentic answer of the other end that is not a report.
  void lives(Time now) { receiver_.lives(now); }
  /// The host there says that nobody has this port. A receiver that has just reported is believed instead.
  void refused(Time now) { receiver_.refused(now); }
  /// From now on datagrams go to another address, which has to answer first.
  void move(std::uint64_t secret, std::shared_ptr<UnprovenBudget> host = {});
  /// When to try again, if nothing is heard until then.
  Time next_ready(Time now) const;

  std::uint64_t position() const { return sent_; }
  /// The shortest time there and back of late; 0: not known.
  Time::duration round_trip() const {
    const auto shortest = round_trips_.shortest();
    return shortest == Time::duration::max() ? Time::duration{} : shortest;
  }
  /// The receiver has reported, and is not silent: nobody else decides that something is sent there.
  bool answers(Time now) const { return !limits_.asks || (receiver_.heard() && !receiver_.is_mute(now)); }
  /// True if the receiver was asked for a second, and never answered or does not answer any more.
  bool is_mute(Time now) const { return receiver_.is_mute(now); }
  /// True if everything that was sent up to that position has arrived, or never will.
  bool passed(std::uint64_t position) const { return position <= (receiver_.heard() ? reported_ : passed_); }
  std::size_t under_way() const { return static_cast<std::size_t>(sent_ - passed_); }
  std::size_t window() const { return std::min(share_, congestion_.bytes()); }

 private:
  void pass_time(Time now);
  double assumed_rate() const;
  bool answer_is_due() const { return marked_ > reported_; }
  void note_unproven(std::size_t bytes, std::size_t datagrams, Time now);
  std::size_t mark_spacing() const;
  bool mark_is_due(Time now, bool is_uncertain) const;
  /// The inverse of itself: hides a time in a mark, and recovers it from a report.
  std::int64_t hidden(std::int64_t ns) const {
    return static_cast<std::int64_t>(static_cast<std::uint64_t>(ns) ^ secret_);
  }
  void learn(const FlowReport& report, Time now);

  std::uint32_t flow_;
  FlowLimits limits_;
  std::uint64_t secret_;
  std::size_t share_ = 0;  ///< of the receiver's buffer
  std::uint64_t sent_ = 0;
  std::uint64_t passed_ = 0;    ///< reported, or believed to have passed
  std::uint64_t reported_ = 0;  ///< the last report was of that
  std::uint64_t marked_ = 0;
  std::uint32_t datagrams_ = 0;
  double expansion_ = 1;  ///< socket bytes for each byte of late
  Time passed_at_{};      ///< when passed_ was brought up to date
  bool waiting_ = false;
  UnprovenAllowance unproven_;
  ReceiverMonitor receiver_;
  RoundTrips round_trips_;
  DeliveryRate rate_;
  CongestionWindow congestion_;
};

}  // namespace sft::udp
