#include "core/node/simulated_clock.h"

#include "core/platform/forked.h"

namespace sft::core {

/// Returns the latest time. In a forked process the lock is not taken, because a thread that does not exist
/// in the forked process may hold the lock for ever.
std::chrono::nanoseconds SimulatedClock::now() {
  if (is_forked_copy()) return std::chrono::nanoseconds(now_ns_.load());
  const Lock lock(mutex_);
  if (const DynamicSample sample = samples_.take_latest()) {
    const DynamicView clock = sample.view()["clock"];
    const auto sec = clock["sec"].as<std::int32_t>();
    const auto nanosec = clock["nanosec"].as<std::uint32_t>();
    if (sec && nanosec) now_ns_ = std::int64_t{*sec} * 1'000'000'000 + *nanosec;
  }
  return std::chrono::nanoseconds(now_ns_.load());
}

}  // namespace sft::core
