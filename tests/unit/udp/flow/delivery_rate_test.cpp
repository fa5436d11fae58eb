#include "udp_transport/flow/delivery_rate.h"

#include <gtest/gtest.h>

#include "tests/unit/udp/start.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;

/// The times in these tests count from the beginning of the test.
class DeliveryRateTest : public testing::Test {
 protected:
  using Duration = DeliveryRate::Time::duration;

  void mark(Duration at) { rate.mark(test_start + at); }
  void report(std::uint64_t position, Duration marked_at, Duration at) {
    rate.report(position, test_start + marked_at, test_start + at);
  }

  DeliveryRate rate;
};

TEST_F(DeliveryRateTest, IsNotKnownBeforeAReport) {
  EXPECT_EQ(rate.bytes_within(1s), 0U);
  mark(0ms);
  EXPECT_EQ(rate.bytes_within(1s), 0U);
}

TEST_F(DeliveryRateTest, IsWhatPassedWhileAMarkAndItsReportWereUnderWay) {
  report(500, 0ms, 0ms);
  mark(1ms);
  report(10'500, 1ms, 10ms);
  EXPECT_EQ(rate.bytes_within(1ms), 1000U);
  EXPECT_EQ(rate.bytes_within(4ms), 4000U);
}

TEST_F(DeliveryRateTest, IsTheBestOfLate) {
  report(0, 0ms, 0ms);
  mark(1ms);
  report(10'000, 1ms, 2ms);
  mark(2ms);
  report(20'000, 2ms, 102ms);
  EXPECT_EQ(rate.bytes_within(1ms), 5000U);
}

TEST_F(DeliveryRateTest, RemembersTheBestOneForAQuarterOfASecond) {
  report(0, 0ms, 0ms);
  mark(0ms);
  report(100, 0ms, 1ms);
  mark(240ms);
  report(480'100, 240ms, 241ms);
  for (auto at = 241ms; at <= 480ms; at += 20ms) {
    mark(at);
    report(480'200, at, at + 1ms);
  }
  EXPECT_EQ(rate.bytes_within(1ms), 2000U);
}

TEST_F(DeliveryRateTest, ForgetsABestOneThatIsHalfASecondOld) {
  report(0, 0ms, 0ms);
  mark(0ms);
  report(10'000, 0ms, 1ms);
  for (auto at = 1ms; at <= 600ms; at += 100ms) {
    mark(at);
    report(10'000 + static_cast<std::uint64_t>(at.count()) * 10, at, at + 100ms);
  }
  EXPECT_LT(rate.bytes_within(1ms), 100U);
}

TEST_F(DeliveryRateTest, IsNoHigherWhereReportsComeAllAtOnce) {
  report(0, 0ms, 0ms);
  for (const auto at : {1ms, 2ms, 3ms, 4ms}) mark(at);
  for (const auto at : {1ms, 2ms, 3ms, 4ms}) report(static_cast<std::uint64_t>(at.count()) * 1000, at, 20ms);
  EXPECT_EQ(rate.bytes_within(1ms), 200U) << "4000 bytes in 20 ms";
}

TEST_F(DeliveryRateTest, LearnsNothingFromAReportWhoseMarkIsForgotten) {
  report(0, 0ms, 0ms);
  for (auto at = 1ms; at <= 9ms; ++at) mark(at);
  report(10'000, 1ms, 20ms);
  EXPECT_EQ(rate.bytes_within(1s), 0U);
}

}  // namespace
}  // namespace sft::udp
