#include "udp_transport/flow/receiver_monitor.h"

#include <algorithm>

namespace sft::udp {

namespace {
/// If more time passes between two flow marks, the silence of the receiver is counted anew.
constexpr std::chrono::seconds longest_pause_between_marks{3};
}  // namespace

void ReceiverMonitor::ask(bool again, Time now) {
  unanswered_ = again ? unanswered_ + 1 : 0;
  if (first_marked_at_ == Time{}) first_marked_at_ = now;
  if (!asked_since_ || (!is_mute(now) && now - marked_at_ > longest_pause_between_marks)) {
    asked_since_ = now;
    asked_ = 0;
  }
  ++asked_;
  put_off(now);
}

/// Notes the later of both times, because another thread may have read the clock earlier.
void ReceiverMonitor::put_off(Time now) { marked_at_ = std::max(marked_at_, now); }

void ReceiverMonitor::note_life(Time now) {
  heard_at_ = now;
  asked_since_.reset();
  asked_ = 0;
  refused_ = false;
}

void ReceiverMonitor::reported(Time now) {
  heard_ = true;
  note_life(now);
  unanswered_ = 0;
}

void ReceiverMonitor::lives(Time now) {
  acks_come_ = true;
  if (heard_ && !is_silent(now)) note_life(now);
}

void ReceiverMonitor::refused(Time now) {
  if (!limits_.asks || (heard_ && now - heard_at_ < limits_.mark_silent)) return;
  refused_ = true;
  if (!asked_since_) asked_since_ = now;
}

void ReceiverMonitor::begin_anew() {
  heard_ = false;
  first_marked_at_ = {};
  asked_since_.reset();
  asked_ = 0;
  refused_ = acks_come_ = false;
}

/// Returns the pause before an unanswered flow mark is repeated. The pause grows while the receiver does not
/// answer. On a path with short round trips, the pause stays short until the receiver counts as mute: the
/// answer was probably lost, and a longer pause would only block the window for longer.
ReceiverMonitor::Time::duration ReceiverMonitor::retry_pause(const RoundTrips& round_trips) const {
  if (is_mute(marked_at_)) {
    const Time::duration longest = heard_ ? limits_.mark_silent_longest : limits_.mark_unproven_longest;
    return std::clamp<Time::duration>((marked_at_ - *asked_since_) / 8, limits_.mark_silent, longest);
  }
  const auto first =
      std::clamp<Time::duration>(2 * round_trips.latest(), limits_.mark_again, limits_.mark_again_unheard);
  const auto after = [first](int marks) { return first * (1 << std::min(marks, 6)); };
  const auto longest = std::clamp<Time::duration>(
      8 * std::min<Time::duration>(round_trips.shortest(), limits_.mark_again_longest),
      limits_.mark_again_unheard, limits_.mark_again_longest);
  return heard_ ? std::min(after(unanswered_), longest)
                : std::min<Time::duration>(after(std::max(asked_ - 1, 0)), limits_.mark_silent);
}

/// Returns true if a new flow mark is due. An ack is no evidence that long datagrams arrive, so acks do not
/// count while that arrival is uncertain.
bool ReceiverMonitor::has_to_ask_anew(Time now, bool is_uncertain) const {
  const Time known_at = is_uncertain ? marked_at_ : std::max(heard_at_, marked_at_);
  if (asked_since_) return now - known_at >= limits_.mark_silent;
  if (is_uncertain) return now - known_at >= anew_unconfirmed;
  return now - known_at >= (acks_come_ ? limits_.mark_anew_behind_acks : limits_.mark_anew);
}

}  // namespace sft::udp
