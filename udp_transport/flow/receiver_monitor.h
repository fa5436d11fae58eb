// Tells whether a receiver answers the marks that it is sent, and when it may be asked again. Pure.
//
// It counts as mute once several marks, which are not too far from each other, have been without an answer
// for FlowLimits::silence: one may get lost, and a pause in what is sent is no silence of the receiver.
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

  /// The receiver has reported.
  bool heard() const { return heard_; }
  /// The receiver was asked, and never answered or does not answer any more.
  bool is_mute(Time now) const {
    return asked_since_ &&
           (refused_ || (asked_ >= marks_of_silence && now - *asked_since_ >= limits_.silence));
  }
  /// The same, of a receiver that has reported.
  bool is_silent(Time now) const { return heard_ && is_mute(now); }
  /// A mark was sent since it was heard last.
  bool is_asked() const { return asked_since_.has_value(); }

  /// A mark is sent; `again`: nothing else was sent since the one before.
  void ask(bool again, Time now);
  /// A mark was due and could not be sent: the next one may go in its turn.
  void put_off(Time now);
  /// Returns true if a mark may have been sent at that time.
  bool may_have_asked_at(Time time) const {
    return first_marked_at_ != Time{} && time >= first_marked_at_ && time <= marked_at_;
  }
  /// A report came.
  void reported(Time now);
  /// The other end has said something else that only it can say.
  void lives(Time now);
  /// The host there says that nobody has this port. A receiver that has just reported is believed instead.
  void refused(Time now);
  /// The receiver has another address, which has to answer first.
  void begin_anew();

  /// The time at which a mark that was not answered is followed by another one.
  Time next_retry(const RoundTrips& round_trips) const { return marked_at_ + retry_pause(round_trips); }
  /// A mark follows what was sent after this time if a part of it may not have arrived.
  static constexpr std::chrono::milliseconds anew_unconfirmed{40};
  /// True if nothing was heard for a time after which the receiver has to be asked about what was sent.
  /// `is_uncertain`: part of it may not have arrived.
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
  int unanswered_ = 0;               ///< marks that were sent again
  std::optional<Time> asked_since_;  ///< the first mark behind the last report
  int asked_ = 0;                    ///< marks since then
  bool refused_ = false;
  bool heard_ = false;
  bool acks_come_ = false;
};

}  // namespace sft::udp
