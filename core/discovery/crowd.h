// How much longer things take, or have to wait, where there are many participants. Pure.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>

namespace sft::core {

/// The number of participants that count; more may be made up.
inline constexpr std::size_t crowd_max = 200;

/// `each`: for each participant but the first. 0 where there are no others.
constexpr std::chrono::milliseconds for_others(std::chrono::milliseconds each, std::size_t participants) {
  return each * (std::clamp<std::size_t>(participants, 1, crowd_max) - 1);
}

}  // namespace sft::core
