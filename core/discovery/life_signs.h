// The pace of the signs of life that nodes give each other.
#pragma once

#include <chrono>

namespace sft::core {

/// How often a node says that it lives, and after how long without that it is lost: six in a row may get
/// lost. Of ten nodes that lose a fifth of all packets, one is then lost falsely every ten minutes or so, and
/// returns with the next.
struct LifeSigns {
  std::chrono::milliseconds pause;
  std::chrono::milliseconds lease;
};
inline constexpr LifeSigns life_signs_to_all{std::chrono::milliseconds(650), std::chrono::milliseconds(5000)};
/// Without multicast, where each node has to be told by itself.
inline constexpr LifeSigns life_signs_to_each{std::chrono::milliseconds(1950),
                                              std::chrono::milliseconds(14'000)};

}  // namespace sft::core
