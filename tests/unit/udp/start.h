// The time at which tests with simulated time begin.
#pragma once

#include <chrono>

namespace sft::udp {

inline constexpr std::chrono::steady_clock::time_point test_start{std::chrono::hours(1)};

}  // namespace sft::udp
