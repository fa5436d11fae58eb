// Random tests draw a seed of their own, say it when they fail, and take it back: --gtest_random_seed=SEED.
#pragma once

#include <gtest/gtest.h>

#include <random>
#include <string>

namespace sft::udp::test {

inline unsigned seed() {
  const auto given = static_cast<unsigned>(GTEST_FLAG_GET(random_seed));
  return given != 0 ? given : 1 + std::random_device{}() % 99'998;
}

inline std::string naming(unsigned seed) { return "repeat with --gtest_random_seed=" + std::to_string(seed); }

}  // namespace sft::udp::test
