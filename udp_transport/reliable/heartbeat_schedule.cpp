#include "udp_transport/reliable/heartbeat_schedule.h"

#include <algorithm>

namespace sft::udp {

void HeartbeatSchedule::sent(bool is_new, Kept kept, Time now) {
  if (is_new && sample_at_ != Time{}) learn_pause(now - sample_at_);
  sample_at_ = now;
  if (unanswered_ == 0) plan(kept, now);
}

/// Updates the usual pause between samples. A much longer pause, as after a burst, has only a small effect.
/// The pause can be negative, because two threads that send at the same time may note their samples in the
/// wrong order.
void HeartbeatSchedule::learn_pause(Time::duration pause) {
  pause = std::max(pause, Time::duration{});
  if (usual_pause_ == Time::duration{}) {
    usual_pause_ = pause;
  } else if (pause > usual_pause_) {
    usual_pause_ += std::min(pause - usual_pause_, usual_pause_) / 8;
  } else {
    usual_pause_ -= (usual_pause_ - pause) / 4;
  }
}

void HeartbeatSchedule::answered(Kept kept, Time now) {
  unanswered_ = 0;
  plan(kept, now);
}

void HeartbeatSchedule::way_changed(Kept kept, Time now) {
  if (kept == Kept::nothing) return;
  unanswered_ = 0;
  next_ = now;
}

/// Returns the time from which a heartbeat is useful. The receiver notices a loss by the next sample, so a
/// heartbeat is needed only if no sample comes after the usual pause. The budget of heartbeats may make the
/// time later.
HeartbeatSchedule::Time HeartbeatSchedule::end_of_usual_pause() const {
  const Time affordable = paid_until_ - limits_.heartbeats_saved * limits_.heartbeat_pause;
  return std::max(sample_at_ + 2 * usual_pause_, affordable);
}

void HeartbeatSchedule::plan(Kept kept, Time now) {
  if (kept == Kept::nothing) {
    next_ = Time::max();
  } else if (heartbeat_at_ == Time{}) {
    next_ = now;  // the first heartbeat gives the receiver the port for acks
  } else if (is_wanted_) {
    next_ = std::min(next_, std::max(now, heartbeat_at_ + limits_.heartbeat_delay));
  } else if (kept == Kept::more_than_half) {
    next_ = std::max(now, heartbeat_at_ + limits_.heartbeat_pause);
  } else {
    const bool bad_link = lost_at_ && now - *lost_at_ < limits_.mistrust;
    const Time usual = heartbeat_at_ + (bad_link ? limits_.heartbeat_delay : limits_.heartbeat_period);
    next_ = std::max(sample_at_ + limits_.heartbeat_delay, std::min(usual, end_of_usual_pause()));
  }
}

bool HeartbeatSchedule::take(Kept kept, Time now) {
  if (is_wanted_ && unanswered_ == 0) plan(kept, now);
  if (now < next_) return false;
  is_wanted_ = false;
  heartbeat_at_ = now;
  paid_until_ = std::max(paid_until_, now) + limits_.heartbeat_pause;
  const auto doubled = limits_.heartbeat_delay * (1 << std::min(++unanswered_, 10));
  next_ = now + std::min<Time::duration>(doubled, limits_.heartbeat_longest);
  return true;
}

}  // namespace sft::udp
