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

/// A link that does not hear a node's signs of life is made anew after a lease. It takes so long at most
/// until signs are heard by the new one.
inline constexpr std::chrono::seconds renewal_takes{4};

}  // namespace sft::core
