// The clock that samples are stamped with, and the one that deadlines are kept by.
#pragma once

#include <chrono>
#include <cstdint>

namespace sft::core {

/// CLOCK_REALTIME in ns: what samples are stamped with. Comparable between hosts as well as their clocks are.
inline std::int64_t realtime_ns() noexcept {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::nanoseconds>(now).count();
}

/// Returns true if a stamp lies more than `age_ns` before `now_ns`. The stamp may be any number; the other
/// two are not negative.
constexpr bool is_older(std::int64_t stamp_ns, std::int64_t age_ns, std::int64_t now_ns) noexcept {
  return stamp_ns < now_ns - age_ns;
}

/// Returns the time at which a wait is over: the end of time if the timeout is too long for anything else.
inline std::chrono::steady_clock::time_point deadline_after(std::chrono::nanoseconds timeout) noexcept {
  using Clock = std::chrono::steady_clock;
  const auto now = Clock::now();
  return timeout > Clock::time_point::max() - now ? Clock::time_point::max() : now + timeout;
}

}  // namespace sft::core
