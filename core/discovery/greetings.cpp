#include "core/discovery/greetings.h"

#include <algorithm>

namespace sft::core {

namespace {
constexpr std::chrono::milliseconds pause_first{50};
constexpr std::chrono::milliseconds pause_max{12'800};
constexpr std::chrono::seconds pause_while_missing{1};
constexpr std::chrono::milliseconds after_newcomer{100};
constexpr std::chrono::seconds pause_between_newcomers{1};
}  // namespace

void Greetings::begin(Time now) {
  pause_ = pause_first;
  next_ = now + pause_;
}

void Greetings::newcomer(Time now) {
  if (!for_newcomer_) for_newcomer_ = std::max(now + after_newcomer, last_ + pause_between_newcomers);
}

bool Greetings::due(Time now, bool somebody_is_missing) {
  const bool at_the_end = pause_ == pause_max;
  const bool in_turn = now >= next_ && (!at_the_end || somebody_is_missing);
  if (!in_turn && (!for_newcomer_ || now < *for_newcomer_)) return false;
  for_newcomer_.reset();
  last_ = now;
  if (!in_turn) return true;
  pause_ = std::min(4 * pause_, pause_max);
  next_ =
      now + (somebody_is_missing ? std::min<std::chrono::milliseconds>(pause_, pause_while_missing) : pause_);
  return true;
}

Time Greetings::next() const {
  return std::min(pause_ == pause_max ? Time::max() : next_, for_newcomer_.value_or(Time::max()));
}

}  // namespace sft::core
