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

struct FlowLimits {
  bool asks = true;  ///< false: nobody is asked to report, or waited for: a multicast group
  std::uint64_t unheard_bytes_per_s = 600'000'000;  ///< that pass where nobody is asked
  std::uint64_t unasked_bytes_per_s = 1'000'000;    ///< that receivers take, as we believe without a report;
                                                    ///< here datagrams count as long as they are
  // These limits hold for a receiver that has not reported yet.
  std::size_t unproven_bytes = 24'000;
  std::size_t unproven_datagrams = 16;
  std::size_t unproven_marks = 8;                  ///< more of them count as datagrams to the host
  std::size_t first_bytes = std::size_t{1} << 20;  ///< under way, before anything is known of the way
  std::size_t least_bytes = 32 * 1024;             ///< under way, however bad it is
  std::size_t mark_spacing_min = 24 * 1024;
  std::size_t mark_spacing_max = 3072 * 1024;
  std::chrono::milliseconds queueing{4};    ///< more than the shortest time there and back
  std::chrono::milliseconds mark_again{2};  ///< after twice the time there and back, but not before
  std::chrono::milliseconds mark_again_unheard{10};
  std::chrono::milliseconds mark_again_longest{50};
  std::chrono::milliseconds mark_anew{2000};  ///< after the last report, if anything is sent
  /// The same where acks come. A slow reliable flow has one every 4 s (ResendLimits::heartbeat_period), which
  /// does what a mark would.
  std::chrono::milliseconds mark_anew_behind_acks{4500};
  std::chrono::milliseconds silence{1000};  ///< after which nothing but marks is sent
  // Between two marks to a receiver that is silent, or has never reported: longer the longer it lasts, but it
  // is served again soon after it has come back.
  std::chrono::milliseconds mark_silent{250};
  std::chrono::milliseconds mark_silent_longest{750};
  std::chrono::milliseconds mark_unproven_longest{2000};
};

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

  /// Socket bytes that may be sent now. The last datagrams may take more. Where there is no room somebody
  /// waits until hear() or next_ready() says that there is.
  std::size_t room(Size size, Time now);
  /// Somebody waits for more room than there is.
  void await_room() { waiting_ = true; }
  /// Returns true if a heartbeat or an offer may go. It takes no room, apart from the few datagrams of the
  /// beginning.
  bool takes_control(Time now);
  /// The largest batch of which several fit into the window.
  std::size_t batch_bytes() const;
  /// `aside`: not the way that marks go.
  void sent(std::size_t bytes, std::size_t datagrams, Time now, bool aside = false);

  /// If one is due: it goes the way that what was sent last has gone. Its port is left to the caller.
  std::optional<FlowMark> mark(Time now);
  /// Returns true if a report can be the answer to one of our marks.
  bool answers_a_mark(const FlowReport& report) const;
  /// Takes a report of the other end; nonsense is ignored. Returns true if somebody waits who may go on now.
  [[nodiscard]] bool hear(const FlowReport& report, Time now);
  /// The other end has said something else that only it can say.
  void lives(Time now);
  /// The host there says that nobody has this port. A receiver that has just reported is believed instead.
  void refused(Time now);
  /// From now on datagrams go to another address, which has to answer first.
  void move(std::uint64_t secret, std::shared_ptr<UnprovenBudget> host = {});
  /// When to try again, if nothing is heard until then.
  Time next_ready(Time now) const;

  std::uint64_t position() const { return sent_; }
  /// The shortest time there and back of late; 0: not known.
  Time::duration round_trip() const {
    return shortest_ == Time::duration::max() ? Time::duration{} : shortest_;
  }
  /// The receiver has reported, and is not silent: nobody else decides that something is sent there.
  bool answers(Time now) const { return !limits_.asks || (heard_ && !silent(now)); }
  /// True if the receiver was asked for a second, and never answered or does not answer any more.
  bool is_mute(Time now) const;
  /// True if everything that was sent up to that position has arrived, or never will.
  bool passed(std::uint64_t position) const { return position <= (heard_ ? reported_ : passed_); }
  std::size_t under_way() const { return static_cast<std::size_t>(sent_ - passed_); }
  std::size_t window() const { return std::min(share_, sustainable_); }

 private:
  void pass_time(Time now);
  double believed_rate() const;
  bool answer_is_due() const { return marked_ > reported_; }
  bool silent(Time now) const { return heard_ && is_mute(now); }
  std::size_t unproven_datagrams_left(Time now) const;
  std::size_t room_before_report(Size size, Time now) const;
  void note_unproven(std::size_t bytes, std::size_t datagrams, Time now);
  bool takes_mark(Time now);
  Time::duration retry_pause() const;
  std::size_t mark_spacing() const;
  bool mark_is_due(Time now) const;
  Time next_retry() const { return marked_at_ + retry_pause(); }
  void note_life(Time now);
  /// The inverse of itself: hides a time in a mark, and recovers it from a report.
  std::int64_t hidden(std::int64_t ns) const {
    return static_cast<std::int64_t>(static_cast<std::uint64_t>(ns) ^ secret_);
  }
  void learn(const FlowReport& report, Time now);
  void note_time_there_and_back(Time::duration time, Time now);
  bool lost_much(const FlowReport& report) const;

  std::uint32_t flow_;
  FlowLimits limits_;
  std::uint64_t secret_;
  std::shared_ptr<UnprovenBudget> host_;
  std::size_t share_;        ///< of the receiver's buffer
  std::size_t sustainable_;  ///< what the way carries without a long queue
  std::uint64_t sent_ = 0;
  std::uint64_t passed_ = 0;        ///< reported, or believed to have passed
  std::size_t unproven_bytes_ = 0;  ///< sent before the first report
  std::size_t unproven_datagrams_ = 0;
  std::size_t unproven_marks_ = 0;
  std::uint64_t reported_ = 0;  ///< the last report was of that
  std::uint64_t marked_ = 0;
  std::uint32_t datagrams_ = 0;
  double expansion_ = 1;  ///< socket bytes for each byte of late
  Time passed_at_{};      ///< when passed_ was brought up to date
  Time marked_at_{};
  Time first_marked_at_{};
  Time heard_at_{};
  int unanswered_ = 0;               ///< marks that were sent again
  std::optional<Time> asked_since_;  ///< the first mark behind the last report
  int asked_ = 0;                    ///< marks since then
  bool refused_ = false;
  bool heard_ = false;
  bool waiting_ = false;
  bool acks_come_ = false;

  // These members describe the way:
  Time::duration latest_ = limits_.mark_again_unheard;  ///< there and back
  Time::duration shortest_ = Time::duration::max();     ///< likewise
  Time shortest_at_{};
  std::uint64_t full_at_ = 0;    ///< position where as much as it carries was under way last
  std::uint64_t turned_at_ = 0;  ///< position where sustainable_ was made smaller
  std::uint32_t datagrams_at_report_ = 0;
  std::uint32_t came_at_report_ = 0;
};

}  // namespace sft::udp
