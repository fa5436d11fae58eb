// Makes random tests repeatable: SFT_TEST_SEED=n is the seed of all random numbers in a test program.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <string>

namespace sft::test {

using Random = std::mt19937_64;

/// Returns $SFT_TEST_SEED if it is set. Otherwise returns a fixed seed if $SFT_TEST_FIXED_SEEDS is set, as in
/// CI, so that CI never fails by chance. If neither is set, returns a new seed for each process. The first
/// call prints the seed to the standard error.
std::uint64_t test_seed();

/// Returns the number of times that a random test repeats its work: `usual`, or in longer runs
/// $SFT_TEST_TIMES times `usual`.
std::uint64_t test_rounds(std::uint64_t usual);

/// Returns the text with which a failure names the seed, such as "to repeat: SFT_TEST_SEED=7".
std::string how_to_repeat();

/// The base class of tests with random inputs. Each failure names the seed, and so does the test's result.
class RandomTest : public ::testing::Test {
 protected:
  RandomTest();

  Random random{test_seed()};

 private:
  ::testing::ScopedTrace trace_;
};

}  // namespace sft::test
