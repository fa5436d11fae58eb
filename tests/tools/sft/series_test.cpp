// The command sft shows statistics of the last few seconds.
#include "tools/sft/series.h"

#include <gtest/gtest.h>

namespace sft::test {
namespace {

using namespace std::chrono_literals;
using tool::Moment;
using tool::Periods;

static_assert(Moment::clock::is_steady, "a clock that is set back would make periods negative");

TEST(PeriodsTest, AreThoseBetweenEventsOfTheLastFewSeconds) {
  Periods periods;
  for (const auto at : {1000ms, 1010ms, 1040ms, 1060ms}) periods.add(Moment() + at);
  EXPECT_EQ(periods.spread().count, 3U);
  EXPECT_DOUBLE_EQ(periods.spread().min, 0.01);
  EXPECT_DOUBLE_EQ(periods.spread().max, 0.03);
  EXPECT_DOUBLE_EQ(periods.rate(), 50);
  periods.forget_before(Moment() + 1050ms);
  EXPECT_EQ(periods.spread().count, 1U);
}

}  // namespace
}  // namespace sft::test
