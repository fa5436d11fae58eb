// Random tests that can be repeated: SFT_TEST_SEED=n is the seed of all random numbers in a test program.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <string>

namespace sft::test {

using Random = std::mt19937_64;

/// $SFT_TEST_SEED; or else the same one each time if $SFT_TEST_FIXED_SEEDS is set, as it is in CI, so that
/// chance fails no landing; or else a new one for each process. Its first call prints it to the standard
/// error.
std::uint64_t test_seed();

/// `usual`, or $SFT_TEST_TIMES as many: how often a random test does what it does, in longer runs of the
/// same.
std::uint64_t test_rounds(std::uint64_t usual);

/// Returns what a failure says: "to repeat: SFT_TEST_SEED=7".
std::string how_to_repeat();

/// A test with random inputs. Each of its failures names the seed, and so does its result.
class RandomTest : public ::testing::Test {
 protected:
  RandomTest();

  Random random{test_seed()};

 private:
  ::testing::ScopedTrace trace_;
};

}  // namespace sft::test
