// The clock for stamps of samples, and the clock for deadlines.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

namespace sft::core {

/// A point in time of the clock for deadlines, pauses and leases.
using Time = std::chrono::steady_clock::time_point;
/// A function that returns the time of that clock, or of the clock of a test.
using ReadTime = Time (*)();

/// Returns the time of CLOCK_REALTIME in ns. Samples are stamped with this time. Stamps of different hosts
/// are comparable only if the clocks of the hosts agree.
inline std::int64_t realtime_ns() noexcept {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::nanoseconds>(now).count();
}

/// The time of CLOCK_REALTIME, read at the first use. Many decisions turn out not to need the time. Then
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

/// Returns true if the stamp is more than `age_ns` before `now_ns`. The stamp may have any value; the other
/// two arguments must not be negative.
constexpr bool is_older(std::int64_t stamp_ns, std::int64_t age_ns, std::int64_t now_ns) noexcept {
  return stamp_ns < now_ns - age_ns;
}

/// Returns the end of a wait that begins now, or Time::max() if that time is outside the range of the
/// clock.
inline Time deadline_after(std::chrono::nanoseconds timeout) noexcept {
  const Time now = std::chrono::steady_clock::now();
  return timeout > Time::max() - now ? Time::max() : now + timeout;
}

}  // namespace sft::core
