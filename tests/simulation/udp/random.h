// Random numbers and times of simulations. All random numbers of a run come from one seed.
#pragma once

#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

namespace sft::simulation {

using Time = std::chrono::steady_clock::time_point;
using Random = std::mt19937_64;
using Bytes = std::vector<std::byte>;

/// All runs begin at this time.
inline constexpr Time start_time{std::chrono::hours(1)};

inline bool happens(Random& random, double probability) {
  return std::uniform_real_distribution<>()(random) < probability;
}

inline std::uint64_t from_to(Random& random, std::uint64_t least, std::uint64_t most) {
  return std::uniform_int_distribution<std::uint64_t>(least, most)(random);
}

/// Returns a random number from 1 to `most`. All orders of magnitude are equally likely.
inline std::uint64_t log_uniform(Random& random, double most) {
  return static_cast<std::uint64_t>(std::exp(std::uniform_real_distribution<>(0, std::log(most))(random)));
}

}  // namespace sft::simulation
