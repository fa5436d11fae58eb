// These tests check the measured rates of samples that are sent and of samples that pass gates.
#include "udp_transport/multicast/sample_rate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>

namespace sft::udp {
namespace {

using namespace std::chrono_literals;
using Time = SampleRate::Time;
constexpr Time begin{1h};

TEST(PassRateTest, DoesNotCountTheFirstSampleWhichPassesWhateverItSays) {
  PassRate rate(begin, 7);
  EXPECT_EQ(rate.per_s(begin + 1ms, 8), 0);
  EXPECT_DOUBLE_EQ(rate.per_s(begin + 50ms, 10), 20) << "two in a tenth of a second";
  EXPECT_DOUBLE_EQ(rate.per_s(begin + 1s, 10), 2);
}

TEST(PassRateTest, IsThatOfTheLastSeconds) {
  PassRate rate(begin, 0);
  std::uint64_t passed = 1;
  for (auto now = begin; now < begin + 20s; now += 100ms) (void)rate.per_s(now, passed += 10);
  EXPECT_NEAR(rate.per_s(begin + 20s, passed), 100, 3);
  for (auto now = begin + 20s; now < begin + 31s; now += 100ms) (void)rate.per_s(now, passed);
  EXPECT_EQ(rate.per_s(begin + 31s, passed), 0);
}

TEST(PassRateTest, OfRareSamplesIsLowAlsoJustAfterOneHasPassed) {
  PassRate rate(begin, 0);
  std::uint64_t passed = 1;
  double highest = 0;
  for (auto now = begin + 10s; now < begin + 200s; now += 100ms) {
    if ((now - begin) % 10s == 0s) ++passed;
    highest = std::max(highest, rate.per_s(now, passed));
  }
  EXPECT_LE(highest, 0.21);
}

TEST(PassRateTest, OfASampleThatIsTakenBackIsNotBelowZero) {
  PassRate rate(begin, 10);
  EXPECT_EQ(rate.per_s(begin + 1s, 9), 0);
}

TEST(SampleRateTest, BeginsWithWhatWasSentBefore) {
  SampleRate rate(begin, 1'000'000);
  rate.count(1'000'100, begin + 1s);
  EXPECT_DOUBLE_EQ(rate.per_s(), 100);
}

}  // namespace
}  // namespace sft::udp
