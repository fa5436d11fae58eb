#include "core/greetings.h"

#include <algorithm>

namespace sft::core {

namespace {
constexpr std::chrono::milliseconds pause_first{50};
constexpr std::chrono::milliseconds pause_max{3200};  // to which it doubles
}  // namespace

void Greetings::begin(Now now) {
  pause_ = pause_first;
  next_ = now + pause_;
}

bool Greetings::due(Now now, bool somebody_is_missing) {
  const bool at_the_end = pause_ == pause_max;
  if (now < next_ || (at_the_end && !somebody_is_missing)) return false;
  pause_ = std::min(2 * pause_, pause_max);
  next_ = now + pause_;
  return true;
}

}  // namespace sft::core
