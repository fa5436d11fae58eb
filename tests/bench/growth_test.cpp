// These tests check how ./run bench many fits the growth of costs.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "bench/many/exponent.h"

namespace sft::bench {

namespace {

TEST(BenchGrowth, IsTheExponentOfThePowerOfTheSize) {
  EXPECT_NEAR(exponent({{25, 3 * 25.}, {50, 3 * 50.}, {100, 3 * 100.}}), 1, 1e-9);
  EXPECT_NEAR(exponent({{25, 7 * 625.}, {100, 7 * 10'000.}}), 2, 1e-9);
  EXPECT_NEAR(exponent({{25, 4}, {50, 4}, {200, 4}}), 0, 1e-9);
}

TEST(BenchGrowth, LeavesOutSizesThatWereNotMeasured) {
  EXPECT_NEAR(exponent({{25, 5}, {50, 10}, {100, std::numeric_limits<double>::quiet_NaN()}, {200, 0}}), 1,
              1e-9);
}

TEST(BenchGrowth, IsNoNumberWithOneSize) {
  EXPECT_FALSE(std::isfinite(exponent({{25, 5}})));
  EXPECT_FALSE(std::isfinite(exponent({})));
}

}  // namespace

}  // namespace sft::bench
