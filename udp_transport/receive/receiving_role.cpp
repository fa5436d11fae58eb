#include "udp_transport/receive/receiving_role.h"

#include <algorithm>

namespace sft::udp {

template <class Change>
bool ReceivingRole::update_if(Change change) {
  State before = state_.load();
  for (;;) {
    State after = before;
    if (!change(after)) return false;
    if (state_.compare_exchange_weak(before, after)) return true;
  }
}

template <class Change>
void ReceivingRole::update(Change change) {
  update_if([&](State& state) {
    change(state);
    return true;
  });
}

ReceivingRole::Entry ReceivingRole::enter(Time now) {
  Entry entry{};
  const bool entered = update_if([&](State& state) {
    if (state.closed || state.attended > 0) {
      entry = Entry::refused;
    } else if (state.inside != Inside::nobody) {
      entry = Entry::occupied;
    } else if (state.holder == Holder::own && state.in_turn) {
      entry = Entry::promised;
      state.inside = Inside::awaited_waiter;
      return true;
    } else {
      entry = Entry::taken;
      state.inside = Inside::other_thread;
      state.holder = Holder::waiter;
      return true;
    }
    return false;
  });
  if (entered) last_used_ = now;
  return entry;
}

bool ReceivingRole::begin() {
  return update_if([](State& state) {
    if (state.closed || state.attended > 0 || state.holder != Holder::waiter) return false;
    state.in_turn = true;
    return true;
  });
}

void ReceivingRole::end(Time next_deadline) {
  ++turns_;
  next_deadline_ = next_deadline;
  update([](State& state) { state.in_turn = false; });
}

bool ReceivingRole::lost() const {
  const State state = state_.load();
  if (state.closed || state.attended > 0) return true;
  return state.holder != Holder::waiter && state.inside != Inside::awaited_waiter;
}

ReceivingRole::Leaving ReceivingRole::leave(Time now) {
  last_used_ = now;
  bool gives_it_back = false;
  bool is_awaited = false;
  update([&](State& state) {
    state.inside = Inside::nobody;
    gives_it_back = state.holder == Holder::waiter;
    is_awaited = state.behind > 0 || state.attended > 0;
    if (gives_it_back) state.holder = Holder::nobody;
  });
  if (!gives_it_back) return {};
  if (is_awaited) return {.wake = true};
  return {.set_alarm = !alarm_set_.exchange(true)};
}

bool ReceivingRole::wait_behind() {
  bool is_vacant = false;
  update([&](State& state) {
    ++state.behind;
    is_vacant = state.holder == Holder::nobody;
  });
  return is_vacant;
}

void ReceivingRole::unwait_behind() {
  update([](State& state) { --state.behind; });
}

bool ReceivingRole::add_attended() {
  bool is_elsewhere = false;
  update([&](State& state) {
    ++state.attended;
    is_elsewhere = state.holder != Holder::own;
  });
  return is_elsewhere;
}

void ReceivingRole::remove_attended() {
  update([](State& state) { --state.attended; });
}

ReceivingRole::Look ReceivingRole::look(const State& state, Time now, bool readable) const {
  return {.seemed_idle = !state.in_turn && (readable || next_deadline_.load() <= now), .turns = turns_};
}

/// Returns the time of the own thread's next check of the thread with the role. The check comes soon after
/// the next deadline, so that a stopped thread with the role does not delay the work that is due then.
ReceivingRole::Time ReceivingRole::next_look(Time now) const {
  if (last_look_.seemed_idle) return now + second_look;
  const Time due = next_deadline_;
  if (due > now + look_period) return now + look_period;
  return std::max(due, now) + second_look;
}

ReceivingRole::Task ReceivingRole::next(Time now, bool readable) {
  State before = state_.load();
  for (;;) {
    if (before.closed) return {.duty = Duty::stop};
    const Time last_used = last_used_;
    const bool evicts = before.holder == Holder::waiter;
    Look now_seen = last_look_;
    if (evicts) {
      now_seen = look(before, now, readable);
      // The thread with the receiving role counts as idle only if it seems idle at two checks in a row. At
      // the first check, it may be about to receive a datagram that has just come.
      const bool does_nothing =
          now_seen.seemed_idle && last_look_.seemed_idle && now_seen.turns == last_look_.turns;
      const bool must_go = before.attended > 0 && !before.in_turn;
      if (!does_nothing && !must_go) {
        last_look_ = now_seen;
        return {.duty = Duty::stand_by, .until = next_look(now)};
      }
    } else if (before.holder == Holder::nobody) {
      const bool expected_back = before.behind == 0 && before.attended == 0 && now < last_used + vacancy;
      if (expected_back) return {.duty = Duty::stand_by, .until = last_used + vacancy};
    }
    const bool polls = before.attended == 0 && now < last_used + own_again;
    State after = before;
    after.holder = Holder::own;
    after.in_turn = !polls;
    if (!state_.compare_exchange_weak(before, after)) continue;
    last_look_ = now_seen;
    if (!polls) return {.duty = Duty::receive, .evicts = evicts};
    const Time until = std::min(last_used + own_again, next_deadline_.load());
    return {.duty = Duty::poll, .until = until, .evicts = evicts};
  }
}

bool ReceivingRole::take_turn() {
  return update_if([](State& state) {
    if (state.closed || state.holder != Holder::own) return false;
    state.in_turn = true;
    return true;
  });
}

bool ReceivingRole::end_turn(Time next_deadline) {
  ++turns_;
  next_deadline_ = next_deadline;
  bool passes_it_on = false;
  update([&](State& state) {
    state.in_turn = false;
    passes_it_on = state.inside == Inside::awaited_waiter;
    if (!passes_it_on) return;
    state.inside = Inside::other_thread;
    if (state.attended == 0) state.holder = Holder::waiter;
  });
  return passes_it_on;
}

/// The exchange here and the exchange in leave() order the actions of the two threads: a thread that finds
/// `alarm_set_` true has left the role before the alarm rings.
void ReceivingRole::alarm_rang() { alarm_set_.exchange(false); }

void ReceivingRole::close() {
  update([](State& state) { state.closed = true; });
}

bool ReceivingRole::waiter_in_turn() const {
  const State state = state_.load();
  return state.in_turn && state.holder == Holder::waiter;
}

}  // namespace sft::udp
