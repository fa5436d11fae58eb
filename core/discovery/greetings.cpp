#include "core/discovery/greetings.h"

#include <algorithm>

namespace sft::core {

namespace {
constexpr std::chrono::milliseconds pause_first{37};  // so the last of four comes after 3.1 s
constexpr int growth = 4;
constexpr std::chrono::milliseconds pause_end{5000};  // a longer pause is the end
constexpr std::chrono::seconds pause_while_missing{1};
constexpr std::chrono::milliseconds after_newcomer{100};
constexpr std::chrono::seconds pause_between_newcomers{1};
}  // namespace

void Greetings::begin(Time now) {
  pause_ = pause_first;
  next_ = now + pause_;
  last_ = now;
}

void Greetings::newcomer(Time now) {
  if (!for_newcomer_) for_newcomer_ = std::max(now + after_newcomer, last_ + pause_between_newcomers);
}

bool Greetings::due(Time now, bool somebody_is_missing) {
  const bool missed_for_long = somebody_is_missing && now >= last_ + pause_while_missing;
  if (now < next() && !missed_for_long) return false;
  for_newcomer_.reset();
  last_ = now;
  if (now < next_) return true;
  pause_ *= growth;
  next_ = pause_ < pause_end ? now + pause_ : Time::max();
  return true;
}

Time Greetings::next() const { return std::min(next_, for_newcomer_.value_or(Time::max())); }

}  // namespace sft::core
