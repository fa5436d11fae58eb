// The clock that samples are stamped with, and the one that deadlines are kept by.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

namespace sft::core {

/// A moment of the clock that deadlines, pauses and leases are kept by.
using Time = std::chrono::steady_clock::time_point;
/// Reads that clock, or one of a test.
using ReadTime = Time (*)();

/// CLOCK_REALTIME in ns: what samples are stamped with. Comparable between hosts as well as their clocks are.
inline std::int64_t realtime_ns() noexcept {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::nanoseconds>(now).count();
}

/// CLOCK_REALTIME as it is when it is first asked for: most decisions that may need the time do not, and then
/// the clock is not read.
class LazyRealtime {
 public:
  LazyRealtime() = default;
  explicit constexpr LazyRealtime(std::int64_t ns) : ns_(ns) {}
  std::int64_t ns() noexcept {
    if (!ns_) ns_ = realtime_ns();
    return *ns_;
  }

 private:
  std::optional<std::int64_t> ns_;
};

/// True if a stamp is more than `age_ns` before `now_ns`. The stamp may have any value; the other two are not
/// negative.
constexpr bool is_older(std::int64_t stamp_ns, std::int64_t age_ns, std::int64_t now_ns) noexcept {
  return stamp_ns < now_ns - age_ns;
}

/// The end of a wait that begins now; the end of time if the timeout is longer than the clock can tell.
inline Time deadline_after(std::chrono::nanoseconds timeout) noexcept {
  const Time now = std::chrono::steady_clock::now();
  return timeout > Time::max() - now ? Time::max() : now + timeout;
}

}  // namespace sft::core
