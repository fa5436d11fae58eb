// The clock that samples are stamped with.
#pragma once

#include <chrono>
#include <cstdint>

namespace sft::core {

/// CLOCK_REALTIME in ns: what samples are stamped with. Comparable between hosts as well as their clocks are.
inline std::int64_t realtime_ns() noexcept {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::nanoseconds>(now).count();
}

}  // namespace sft::core
