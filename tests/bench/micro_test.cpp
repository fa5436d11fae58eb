// These tests check what ./run bench micro makes of its times: which changes are more than noise, and what a
// kept baseline has.
#include "bench/micro/change.h"

#include <gmock/gmock.h>

#include <sstream>

namespace sft::bench::micro {

namespace {

using testing::HasSubstr;
using testing::IsEmpty;

/// Ratios around `middle`, as far apart as `spread` says.
std::vector<double> around(double middle, double spread, int repetitions = 11) {
  std::vector<double> ratios;
  for (int i = 0; i < repetitions; ++i) ratios.push_back(middle + spread * (2. * i / (repetitions - 1) - 1));
  return ratios;
}

Verdict verdict(const std::vector<double>& before, const std::vector<double>& now) {
  return compare({{"encode", before}}, {{"encode", now}}).at(0).verdict;
}

TEST(MicroInterval, IsBetweenTheRanksOfTheSignTest) {
  // The median of all is between the second smallest and the second largest of twelve in 99.4 % of cases, and
  // between the third ones in 96 %.
  const Interval interval = interval_of({12, 11, 10, 9, 8, 7, 6, 5, 4, 3, 2, 1});
  EXPECT_EQ(interval.low, 2);
  EXPECT_EQ(interval.middle, 6.5);
  EXPECT_EQ(interval.high, 11);
}

TEST(MicroInterval, LeavesOutDisturbedRepetitionsIfThereAreMany) {
  std::vector<double> ratios = around(1, 0.01, 25);
  ratios.front() = 50;
  EXPECT_LT(interval_of(ratios).high, 1.02);
}

TEST(MicroInterval, IsThatOfAllRatiosIfThereAreFew) {
  const Interval interval = interval_of({3, 1, 2, 4});
  EXPECT_EQ(interval.low, 1);
  EXPECT_EQ(interval.middle, 2.5);
  EXPECT_EQ(interval.high, 4);
}

TEST(MicroChange, IsMoreThanNoiseIfTheIntervalsHaveNothingInCommon) {
  EXPECT_EQ(verdict(around(1, 0.02), around(1.2, 0.02)), Verdict::slower);
  EXPECT_EQ(verdict(around(1, 0.02), around(0.8, 0.02)), Verdict::faster);
  EXPECT_EQ(verdict(around(1, 0.2), around(1.2, 0.2)), Verdict::same);
}

TEST(MicroChange, IsNoneIfItIsSmall) {
  EXPECT_EQ(verdict(around(1, 0.001), around(1.04, 0.001)), Verdict::same);
}

TEST(MicroChange, NamesFiguresOfOneRunOnly) {
  const auto changes = compare({{"gone", {1}}}, {{"new", {1}}});
  ASSERT_EQ(changes.size(), 2U);
  EXPECT_EQ(changes[0].verdict, Verdict::only_before);
  EXPECT_EQ(changes[1].verdict, Verdict::only_now);
  EXPECT_THAT(text_of(changes), HasSubstr("0 slower, 0 faster, 0 the same"));
}

TEST(MicroChange, SaysByHowMuch) {
  EXPECT_THAT(text_of(compare({{"encode", around(1, 0.02)}}, {{"encode", around(1.5, 0.02)}})),
              HasSubstr("+50.0 % slower"));
}

TEST(MicroBaseline, IsReadAsItWasWritten) {
  const Ratios ratios{{"encode", {1, 1.5}}, {"view", {0.25}}};
  std::stringstream file;
  write(file, ratios);
  EXPECT_EQ(read(file), ratios);
}

TEST(MicroBaseline, IsEmptyIfTheFileIsSomethingElse) {
  for (const char* text : {"", "[]", "{\"encode\": 1}", "{\"encode\": []}", "{\"encode\": [\"x\"]}"}) {
    std::istringstream file(text);
    EXPECT_THAT(read(file), IsEmpty()) << text;
  }
}

}  // namespace

}  // namespace sft::bench::micro
