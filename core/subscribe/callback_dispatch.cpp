#include "core/subscribe/callback_dispatch.h"

namespace sft::core {

namespace {
thread_local int callback_depth = 0;
constexpr std::chrono::microseconds slow_callback{200};  // far more than it costs to wake another thread
constexpr int quick_again_after = 100;                   // callbacks in a row
}  // namespace

bool CallbackDispatch::in_callback() noexcept { return callback_depth != 0; }

/// Returns when the callback was done. `before`: when the callback before it was done, or the first sample
/// was looked for. So the time counts that taking the sample costs: it is short beside a slow callback, and
/// the clock is read once less.
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
