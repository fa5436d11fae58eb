// The log-linear histogram returns percentiles within its error bounds, and none of too few samples.
#include "tools/perf/histogram.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/support/test_seed.h"

namespace sft::perf {
namespace {

TEST(HistogramTest, APercentileIsWrongByLessThanHalfAPercent) {
  std::mt19937_64 random(test::test_seed());
  std::lognormal_distribution<double> times(12, 2);
  Histogram histogram;
  std::vector<double> values;
  for (int i = 0; i < 50'000; ++i) {
    const auto value = static_cast<std::int64_t>(times(random));
    histogram.add(value);
    values.push_back(static_cast<double>(value));
  }
  std::ranges::sort(values);
  for (const double percent : {1.0, 50.0, 90.0, 99.0, 99.9, 99.99}) {
    const double exact = values[static_cast<std::size_t>(std::ceil(percent / 100 * 50'000 - 1e-6)) - 1];
    EXPECT_NEAR(histogram.percentile(percent).value(), exact, exact * 0.004 + 1) << percent;
  }
}

TEST(HistogramTest, APercentileNeedsEnoughValues) {
  Histogram histogram;
  EXPECT_FALSE(histogram.percentile(50));
  EXPECT_FALSE(histogram.max());
  for (int i = 1; i <= 100; ++i) histogram.add(i);
  EXPECT_EQ(histogram.percentile(50), 50);
  EXPECT_EQ(histogram.percentile(99), 99);
  EXPECT_FALSE(histogram.percentile(99.9)) << "of 100 values nobody knows the worst of 1000";
  for (int i = 0; i < 9'900; ++i) histogram.add(1);
  EXPECT_TRUE(histogram.percentile(99.99));
}

TEST(HistogramTest, SmallestLargestAndMeanAreExact) {
  Histogram histogram;
  for (const std::int64_t value : {1'000'003, 17, 1'000'000'007}) histogram.add(value);
  EXPECT_EQ(histogram.min(), 17);
  EXPECT_EQ(histogram.max(), 1'000'000'007);
  EXPECT_DOUBLE_EQ(histogram.mean().value(), (1'000'003 + 17 + 1'000'000'007) / 3.0);
}

TEST(HistogramTest, EachValueIsInItsClassUpToTheLargestTime) {
  for (const std::int64_t value :
       {std::int64_t{0}, std::int64_t{127}, std::int64_t{128}, std::int64_t{255}, std::int64_t{256},
        std::int64_t{257}, std::int64_t{1} << 40, std::numeric_limits<std::int64_t>::max() / 2}) {
    Histogram histogram;
    histogram.add(value);
    const auto classes = histogram.classes();
    ASSERT_EQ(classes.size(), 1U);
    EXPECT_LE(classes[0].begin, value);
    EXPECT_LT(value, classes[0].end);
    EXPECT_LE(static_cast<double>(classes[0].end - classes[0].begin), 1 + static_cast<double>(value) / 128);
  }
}

TEST(HistogramTest, TheLastClassEndsWithTheLargestTime) {
  constexpr std::int64_t largest = std::numeric_limits<std::int64_t>::max();
  Histogram histogram;
  histogram.add(largest);
  EXPECT_EQ(histogram.classes().at(0).end, largest);
  EXPECT_EQ(histogram.percentile(0), static_cast<double>(largest));
}

TEST(HistogramTest, ANegativeTimeCountsAsZero) {
  Histogram histogram;
  histogram.add(-5);
  EXPECT_EQ(histogram.min(), 0);
}

}  // namespace
}  // namespace sft::perf
