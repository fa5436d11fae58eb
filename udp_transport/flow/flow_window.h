// Flow and congestion control towards one remote socket. It limits the bytes under way to the share of the
// receive buffer that the receiver reports, and to what the path carries without a queue that delays other
// traffic.
//
// A receiver has to answer. Until its first report, only a few small datagrams and flow marks (requests for
// a report) are sent to it. After a second without an answer, only flow marks are sent. So a forged
// announcement cannot make this host flood another one.
//
// The class uses no clock, thread or I/O: events and times are passed in, decisions are returned. All
// amounts are in bytes as the receiving kernel counts them (socket_bytes()). A position is the number of
// such bytes sent so far.
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

/// Returns the memory that datagrams take in a socket's receive buffer, in bytes. It is more than their
/// length, because the kernel stores its own data with each datagram.
constexpr std::size_t socket_bytes(std::size_t bytes, std::size_t datagrams) {
  constexpr std::size_t of_each_datagram = 832;
  return bytes + datagrams * of_each_datagram;
}
/// Returns the number of bytes of a receive buffer that senders may fill. A quarter is left free, because
/// the kernel frees the memory of read datagrams only in steps of a quarter of the buffer.
constexpr std::size_t usable_bytes(std::size_t receive_buffer_bytes) { return receive_buffer_bytes / 4 * 3; }

class FlowWindow {
 public:
  using Time = std::chrono::steady_clock::time_point;
  /// The size of a sample. A part of the window is reserved for small samples.
  enum class Size : std::uint8_t { small, large };

  /// `flow` is the number that the receiver's reports repeat. `secret` hides the times in flow marks, so
  /// that only a process that has received a mark can repeat its content. `host` limits what is sent to all
  /// destinations on the remote host before they answer; null: only the allowance of this destination
  /// counts.
  FlowWindow(std::uint32_t flow, const FlowLimits& limits, std::uint64_t secret = 0,
             std::shared_ptr<UnprovenBudget> host = {});

  /// Sets the announced size of the remote socket's receive buffer. It is used until the first report.
  void announce(std::size_t receive_buffer_bytes);

  /// Returns the number of socket bytes that may be sent now. The last datagrams may exceed that number. If
  /// it is 0, the sender waits until hear() returns true, or until the time that next_ready() returns.
  std::size_t room(Size size, Time now);
  /// Notes that a sender waits until more bytes may be sent.
  void await_room() { waiting_ = true; }
  /// Returns true if a heartbeat or an offer may be sent. Such a datagram does not count in the window.
  /// Before the first report, it counts as one of the few datagrams that may be sent.
  bool takes_control(Time now);
  /// Returns the maximum size of a batch in socket bytes, which is a fraction of the window.
  std::size_t batch_bytes() const;
  /// Notes that datagrams were sent. `aside` is true if they went through a different connection than flow
  /// marks.
  void sent(std::size_t bytes, std::size_t datagrams, Time now, bool aside = false);

  /// Returns the flow mark that is due, if any. The caller fills in the port, and sends the mark through the
  /// connection that was used last. `is_uncertain` is true if a part of the sent data may not have arrived.
  /// Then a mark is due soon.
  std::optional<FlowMark> mark(Time now, bool is_uncertain = false);
  /// Returns true if the report can be the answer to one of our flow marks.
  bool answers_a_mark(const FlowReport& report) const;
  /// Returns the time at which the flow mark that the report answers was sent.
  Time marked_at(const FlowReport& report) const {
    return Time(std::chrono::nanoseconds(hidden(report.sent_at_ns)));
  }
  /// Processes a report of the receiver, and ignores an implausible one. Returns true if a waiting sender
  /// may continue now.
  [[nodiscard]] bool hear(const FlowReport& report, Time now);
  /// Notes an authentic answer of the receiver that is not a report.
  void lives(Time now) { receiver_.lives(now); }
  /// Notes that the remote host has reported (by ICMP) that no socket has this port. Does nothing if the
  /// receiver has just reported.
  void refused(Time now) { receiver_.refused(now); }
  /// Sends to another address from now on. The receiver has to answer at that address first.
  void move(std::uint64_t secret, std::shared_ptr<UnprovenBudget> host = {});
  /// Returns the time at which a sender should try again if no report comes before.
  Time next_ready(Time now) const;

  std::uint64_t position() const { return sent_; }
  /// Returns the shortest recent round trip; 0 if none is known.
  Time::duration round_trip() const {
    const auto shortest = round_trips_.shortest();
    return shortest == Time::duration::max() ? Time::duration{} : shortest;
  }
  /// Returns true if the receiver has reported, and is not silent. A report shows that the receiver itself
  /// wants the data. An announcement alone does not count, because it can be forged.
  bool answers(Time now) const { return !limits_.asks || (receiver_.heard() && !receiver_.is_mute(now)); }
  /// Returns true if the receiver has answered no flow mark for FlowLimits::silence. It may never have
  /// answered, or have stopped answering.
  bool is_mute(Time now) const { return receiver_.is_mute(now); }
  /// Returns true if all datagrams up to that position have arrived, or have been lost.
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
  /// Hides a time in a flow mark, or recovers the time from a report. The function is its own inverse.
  std::int64_t hidden(std::int64_t ns) const {
    return static_cast<std::int64_t>(static_cast<std::uint64_t>(ns) ^ secret_);
  }
  void learn(const FlowReport& report, Time now);

  std::uint32_t flow_;
  FlowLimits limits_;
  std::uint64_t secret_;
  std::size_t share_ = 0;  ///< our share of the receiver's buffer, in bytes
  std::uint64_t sent_ = 0;
  std::uint64_t passed_ = 0;    ///< position up to which all bytes have passed, by reports or by assumption
  std::uint64_t reported_ = 0;  ///< position in the last report
  std::uint64_t marked_ = 0;
  std::uint32_t datagrams_ = 0;
  double expansion_ = 1;  ///< recent average number of socket bytes per sent byte
  Time passed_at_{};      ///< time of the last update of `passed_`
  bool waiting_ = false;
  UnprovenAllowance unproven_;
  ReceiverMonitor receiver_;
  RoundTrips round_trips_;
  DeliveryRate rate_;
  CongestionWindow congestion_;
};

}  // namespace sft::udp
