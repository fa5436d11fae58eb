#include "udp_transport/receive/interval_set.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "tests/support/test_seed.h"

namespace sft::udp {
namespace {

TEST(IntervalSet, StaysOneRangeWhileBytesComeInOrder) {
  IntervalSet set;
  for (std::uint32_t i = 0; i < 100; ++i) EXPECT_EQ(set.add(i * 10, i * 10 + 10), 10U);
  EXPECT_EQ(set.covered(), 1000U);
  EXPECT_EQ(set.intervals().size(), 1U);
}

TEST(IntervalSet, JoinsTheRangesThatAGapSeparated) {
  IntervalSet set;
  set.add(0, 10);
  set.add(20, 30);
  EXPECT_EQ(set.intervals().size(), 2U);
  EXPECT_EQ(set.add(10, 20), 10U);
  EXPECT_EQ(set.intervals().size(), 1U);
}

TEST(IntervalSet, CountsEachByteOnce) {
  IntervalSet set;
  set.add(10, 20);
  EXPECT_EQ(set.add(10, 20), 0U);
  EXPECT_EQ(set.add(12, 13), 0U);
  EXPECT_EQ(set.add(5, 25), 10U);
  EXPECT_EQ(set.covered(), 20U);
}

TEST(IntervalSet, AgreesWithABitmapOnRandomRanges) {
  const std::uint64_t seed = sft::test::test_seed();
  SCOPED_TRACE(sft::test::how_to_repeat());
  std::mt19937 random(seed);
  for (int round = 0; round < 200; ++round) {
    IntervalSet set;
    std::vector<bool> bitmap(300);
    for (int i = 0; i < 60; ++i) {
      const std::uint32_t begin = random() % 290;
      const std::uint32_t end = begin + 1 + random() % std::min<std::uint32_t>(40, 300 - begin - 1);
      const auto first = bitmap.begin() + begin;
      const auto fresh = static_cast<std::uint32_t>(std::count(first, bitmap.begin() + end, false));
      const auto beside = bitmap.begin() + (begin == 0 ? 0 : begin - 1);
      ASSERT_EQ(set.stands_alone(begin, end), std::count(beside, bitmap.begin() + end + 1, true) == 0);
      std::fill(first, bitmap.begin() + end, true);
      ASSERT_EQ(set.add(begin, end), fresh);
      ASSERT_EQ(set.covered(), static_cast<std::uint32_t>(std::count(bitmap.begin(), bitmap.end(), true)));
    }
    for (std::size_t i = 1; i < set.intervals().size(); ++i) {
      ASSERT_LT(set.intervals()[i - 1].end, set.intervals()[i].begin);
    }
  }
}

}  // namespace
}  // namespace sft::udp
