#include "udp_transport/receive/receiving_role.h"

#include <algorithm>
#include <utility>

namespace sft::udp {

ReceivingRole::Entry ReceivingRole::enter(Time now) {
  const core::Lock lock(mutex_);
  if (closed_ || tended_ > 0) return Entry::refused;
  if (inside_) return Entry::occupied;
  inside_ = true;
  last_used_ = now;
  if (holder_ == Holder::own && in_turn_) {
    promised_ = true;
    return Entry::promised;
  }
  holder_ = Holder::waiter;
  return Entry::taken;
}

bool ReceivingRole::begin() {
  const core::Lock lock(mutex_);
  if (closed_ || tended_ > 0 || holder_ != Holder::waiter) return false;
  in_turn_ = true;
  return true;
}

void ReceivingRole::end(Time next_deadline) {
  const core::Lock lock(mutex_);
  in_turn_ = false;
  ++turns_;
  next_deadline_ = next_deadline;
}

bool ReceivingRole::lost() const {
  const core::Lock lock(mutex_);
  return closed_ || tended_ > 0 || (holder_ != Holder::waiter && !promised_);
}

ReceivingRole::Leaving ReceivingRole::leave(Time now) {
  const core::Lock lock(mutex_);
  inside_ = promised_ = false;
  last_used_ = now;
  if (holder_ != Holder::waiter) return {};
  holder_ = Holder::nobody;
  if (behind_ > 0 || tended_ > 0) return {.wake = true};
  return {.set_alarm = !std::exchange(alarm_set_, true)};
}

bool ReceivingRole::wait_behind() {
  const core::Lock lock(mutex_);
  ++behind_;
  return holder_ == Holder::nobody;
}

void ReceivingRole::unwait_behind() {
  const core::Lock lock(mutex_);
  --behind_;
}

bool ReceivingRole::add_tended() {
  const core::Lock lock(mutex_);
  ++tended_;
  return holder_ != Holder::own;
}

void ReceivingRole::remove_tended() {
  const core::Lock lock(mutex_);
  --tended_;
}

/// Twice in a row, a little apart: what has just come it is about to receive.
bool ReceivingRole::seems_idle(Time now, bool readable) {
  const bool idle = !in_turn_ && (readable || next_deadline_ <= now);
  const bool again = idle && seemed_idle_ && turns_seen_ == turns_;
  seemed_idle_ = idle;
  turns_seen_ = turns_;
  return again;
}

/// The own thread does not leave work that is due to a holder that may not do it.
ReceivingRole::Time ReceivingRole::next_look(Time now) const {
  if (seemed_idle_) return now + second_look;
  if (next_deadline_ > now + look_period) return now + look_period;
  return std::max(next_deadline_, now) + second_look;
}

ReceivingRole::Task ReceivingRole::next(Time now, bool readable) {
  const core::Lock lock(mutex_);
  if (closed_) return {.duty = Duty::stop};
  const bool evicts = holder_ == Holder::waiter;
  if (holder_ == Holder::waiter) {
    const bool must_go = tended_ > 0 && !in_turn_;
    if (!seems_idle(now, readable) && !must_go) return {.duty = Duty::stand_by, .until = next_look(now)};
  } else if (holder_ == Holder::nobody) {
    const bool expected_back = behind_ == 0 && tended_ == 0 && now < *last_used_ + vacancy;
    if (expected_back) return {.duty = Duty::stand_by, .until = *last_used_ + vacancy};
  }
  holder_ = Holder::own;
  if (tended_ == 0 && last_used_ && now < *last_used_ + own_again) {
    const Time until = std::min(*last_used_ + own_again, next_deadline_);
    return {.duty = Duty::poll, .until = until, .evicts = evicts};
  }
  in_turn_ = true;
  return {.duty = Duty::receive, .evicts = evicts};
}

bool ReceivingRole::take_turn() {
  const core::Lock lock(mutex_);
  if (closed_ || holder_ != Holder::own) return false;
  in_turn_ = true;
  return true;
}

bool ReceivingRole::end_turn(Time next_deadline) {
  const core::Lock lock(mutex_);
  in_turn_ = false;
  ++turns_;
  next_deadline_ = next_deadline;
  if (!std::exchange(promised_, false)) return false;
  if (tended_ == 0) holder_ = Holder::waiter;
  return true;
}

void ReceivingRole::alarm_rang() {
  const core::Lock lock(mutex_);
  alarm_set_ = false;
}

void ReceivingRole::close() {
  const core::Lock lock(mutex_);
  closed_ = true;
}

bool ReceivingRole::waiter_in_turn() const {
  const core::Lock lock(mutex_);
  return in_turn_ && holder_ == Holder::waiter;
}

}  // namespace sft::udp
