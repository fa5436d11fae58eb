// The initial time of tests that set the time themselves.
#pragma once

#include "core/platform/clock.h"

namespace sft::core {

inline constexpr Time test_start = Time{} + std::chrono::seconds(100);

}  // namespace sft::core
