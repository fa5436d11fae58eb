#include "core/subscribe/callback_dispatch.h"

namespace sft::core {

namespace {
thread_local int callback_depth = 0;
constexpr std::chrono::microseconds slow_callback{200};  // far more than it costs to wake another thread
constexpr int quick_again_after = 100;  // callbacks count as quick after this number of quick ones in a row
}  // namespace

bool CallbackDispatch::in_callback() noexcept { return callback_depth != 0; }

/// Calls back, and returns the time at which the callback has returned. `before` is the time at which the
/// previous callback returned, or at which the search for the first sample began. So the measured time
/// includes the taking of the sample, which is short compared with a slow callback. This saves one reading of
/// the clock.
Time CallbackDispatch::call_back(detail::untyped::Sample sample, Time before) {
  ++callback_depth;
  callback_(std::move(sample));
  --callback_depth;
  const Time done = now_();
  quick_in_a_row_ = done - before < slow_callback ? quick_in_a_row_ + 1 : 0;
  if (quick_in_a_row_ == 0 || quick_in_a_row_ == quick_again_after) is_slow_.store(quick_in_a_row_ == 0);
  return done;
}

}  // namespace sft::core
