// Tells if a receiver answers its marks, and when it may be asked again. Uses no clock, thread or I/O.
//
// A receiver counts as mute if several marks, not too far from each other, have had no answer for
// FlowLimits::silence. A single mark may get lost, and the sender may pause; neither makes the receiver
// mute.
#pragma once

#include <chrono>
#include <optional>

#include "udp_transport/flow/flow_limits.h"
#include "udp_transport/flow/round_trips.h"

namespace sft::udp {

class ReceiverMonitor {
 public:
  using Time = std::chrono::steady_clock::time_point;

  explicit ReceiverMonitor(const FlowLimits& limits) : limits_(limits) {}

  /// Returns true if the receiver has reported.
  bool heard() const { return heard_; }
  /// Returns true if marks to the receiver are unanswered, because it never answered or stopped answering.
  bool is_mute(Time now) const {
    return asked_since_ &&
           (refused_ || (asked_ >= marks_of_silence && now - *asked_since_ >= limits_.silence));
  }
  /// Returns true if the receiver has reported, and is mute now.
  bool is_silent(Time now) const { return heard_ && is_mute(now); }
  /// Returns true if a mark was sent after the receiver's last answer.
  bool is_asked() const { return asked_since_.has_value(); }

  /// Notes that a mark is sent. `again` is true if nothing else was sent since the previous mark.
  void ask(bool again, Time now);
  /// Notes that a mark was due and could not be sent. The next mark is due after the usual pause.
  void put_off(Time now);
  /// Returns true if a mark may have been sent at that time.
  bool may_have_asked_at(Time time) const {
    return first_marked_at_ != Time{} && time >= first_marked_at_ && time <= marked_at_;
  }
  /// Notes a report of the receiver.
  void reported(Time now);
  /// Notes an answer that is no report, and that only the receiver can give.
  void lives(Time now);
  /// Notes that the remote host has reported that no socket has this port. Ignored if the receiver has just
  /// reported.
  void refused(Time now);
  /// Begins again for another address of the receiver. The receiver has to answer at that address first.
  void begin_anew();

  /// Returns the time at which a mark without an answer is followed by another one.
  Time next_retry(const RoundTrips& round_trips) const { return marked_at_ + retry_pause(round_trips); }
  /// Data that may not have arrived is followed by a mark after this time.
  static constexpr std::chrono::milliseconds anew_unconfirmed{40};
  /// Returns true if the receiver has to be asked about the sent data, since it has given no answer for too
  /// long. `is_uncertain` is true if a part of the data may not have arrived.
  bool has_to_ask_anew(Time now, bool is_uncertain = false) const;

 private:
  /// The number of unanswered marks that count as silence.
  static constexpr int marks_of_silence = 3;

  Time::duration retry_pause(const RoundTrips& round_trips) const;
  void note_life(Time now);

  FlowLimits limits_;
  Time marked_at_{};
  Time first_marked_at_{};
  Time heard_at_{};
  int unanswered_ = 0;               ///< number of repeated marks
  std::optional<Time> asked_since_;  ///< time of the first mark after the last answer
  int asked_ = 0;                    ///< number of marks since `asked_since_`
  bool refused_ = false;
  bool heard_ = false;
  bool acks_come_ = false;
};

}  // namespace sft::udp
