// The lease of a node, as others see it: how long nothing may be heard of the node before it counts as lost.
#pragma once

#include <algorithm>
#include <chrono>

namespace sft::core {

/// A node that claims a longer lease counts as lost after this time all the same.
inline constexpr std::chrono::milliseconds lease_max{60'000};

/// The silence after which a speaker does not count as speaking any more. Frequent signs of life come seven
/// times in a lease: two of them may get lost.
constexpr std::chrono::milliseconds silence_in(std::chrono::milliseconds lease) {
  return std::clamp(lease * 3 / 10, std::chrono::milliseconds(300), std::chrono::milliseconds(4500));
}

}  // namespace sft::core
