#include "core/discovery/greetings.h"

#include <algorithm>

#include "core/discovery/crowd.h"

namespace sft::core {

namespace {
constexpr std::chrono::milliseconds pause_first{37};  // so the last of four comes after 3.1 s
constexpr int growth = 4;
constexpr std::chrono::milliseconds pause_end{5000};  // a longer pause is the end
constexpr std::chrono::seconds pause_while_missing{1};
constexpr std::chrono::milliseconds after_newcomer{100};
constexpr std::chrono::seconds pause_between_newcomers{1};
/// Newcomers are strangers for a moment.
constexpr std::chrono::milliseconds patience_with_strangers{3000};
constexpr std::chrono::milliseconds pause_between_strangers_max{60'000};
/// A look in calm (tick_pace.h) may just miss a pulse.
constexpr std::chrono::milliseconds strangers_gone_after{2000};
constexpr std::chrono::milliseconds pause_for_each{40};
}  // namespace

void Greetings::begin(Time now) {
  pause_ = pause_first;
  next_ = now + pause_;
  last_ = now;
}

void Greetings::newcomer(Time now) {
  if (!for_newcomer_) for_newcomer_ = std::max(now + after_newcomer, last_ + pause_between_newcomers);
}

void Greetings::stranger(Time now) {
  if (!strangers_ || now - strangers_->heard >= strangers_gone_after)
    strangers_ = {now, now + patience_with_strangers, patience_with_strangers};
  strangers_->heard = now;
}

void Greetings::others(std::size_t participants) {
  pause_in_crowd_ = for_others(pause_for_each, participants);
}

bool Greetings::due_for_strangers(Time now) {
  if (!strangers_ || now < strangers_->next || now - strangers_->heard >= strangers_gone_after) return false;
  strangers_->pause = std::min(2 * strangers_->pause, pause_between_strangers_max);
  strangers_->next = now + strangers_->pause;
  return true;
}

bool Greetings::due(Time now, bool somebody_is_missing) {
  const bool missed_for_long = somebody_is_missing && now >= last_ + pause_while_missing;
  const bool for_strangers = due_for_strangers(now);
  if (now < next() && !missed_for_long && !for_strangers) return false;
  for_newcomer_.reset();
  last_ = now;
  if (now < next_) return true;
  pause_ *= growth;
  next_ = pause_ < pause_end ? now + pause_ : Time::max();
  return true;
}

Time Greetings::next() const {
  const Time next = std::min(next_, for_newcomer_.value_or(Time::max()));
  const bool is_first = pause_ == pause_first;  // others may have forgotten us
  return is_first ? next : std::max(next, last_ + pause_in_crowd_);
}

}  // namespace sft::core
