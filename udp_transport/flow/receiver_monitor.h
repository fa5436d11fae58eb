// Determines if a receiver answers the flow marks that are sent to it, and when the next mark may be sent.
// Uses no clock, thread or I/O.
//
// A receiver counts as mute if several flow marks, sent at short intervals, have had no answer for
// FlowLimits::silence. A single lost mark, or a pause of the sender, does not make the receiver mute.
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
  /// Returns true if the receiver has not answered several flow marks. It may never have answered, or have
  /// stopped answering.
  bool is_mute(Time now) const {
    return asked_since_ &&
           (refused_ || (asked_ >= marks_of_silence && now - *asked_since_ >= limits_.silence));
  }
  /// Returns true if the receiver has reported, and is mute now.
  bool is_silent(Time now) const { return heard_ && is_mute(now); }
  /// Returns true if a flow mark was sent after the receiver's last answer.
  bool is_asked() const { return asked_since_.has_value(); }

  /// Notes that a flow mark is sent. `again` is true if no other data was sent since the previous mark.
  void ask(bool again, Time now);
  /// Notes that a flow mark was due and could not be sent. The next mark is due after the usual pause.
  void put_off(Time now);
  /// Returns true if a flow mark may have been sent at that time.
  bool may_have_asked_at(Time time) const {
    return first_marked_at_ != Time{} && time >= first_marked_at_ && time <= marked_at_;
  }
  /// Notes a report of the receiver.
  void reported(Time now);
  /// Notes an authentic answer of the receiver that is not a report, such as an ack.
  void lives(Time now);
  /// Notes that the remote host has reported (by ICMP) that no socket has this port. Does nothing if the
  /// receiver has just reported.
  void refused(Time now);
  /// Resets the state for another address of the receiver. The receiver has to answer at that address first.
  void begin_anew();

  /// Returns the time at which an unanswered flow mark is followed by the next one.
  Time next_retry(const RoundTrips& round_trips) const { return marked_at_ + retry_pause(round_trips); }
  /// If sent data may not have arrived, a flow mark follows it after this time.
  static constexpr std::chrono::milliseconds anew_unconfirmed{40};
  /// Returns true if a flow mark has to be sent, because the receiver has not answered about the sent data
  /// for too long. `is_uncertain` is true if a part of the data may not have arrived.
  bool has_to_ask_anew(Time now, bool is_uncertain = false) const;

 private:
  /// The number of unanswered flow marks after which a receiver may count as mute.
  static constexpr int marks_of_silence = 3;

  Time::duration retry_pause(const RoundTrips& round_trips) const;
  void note_life(Time now);

  FlowLimits limits_;
  Time marked_at_{};
  Time first_marked_at_{};
  Time heard_at_{};
  int unanswered_ = 0;               ///< number of repeated flow marks
  std::optional<Time> asked_since_;  ///< time of the first flow mark after the last answer
  int asked_ = 0;                    ///< number of flow marks since `asked_since_`
  bool refused_ = false;
  bool heard_ = false;
  bool acks_come_ = false;
};

}  // namespace sft::udp
