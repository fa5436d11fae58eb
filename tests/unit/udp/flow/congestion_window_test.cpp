#include "udp_transport/flow/congestion_window.h"

#include <gtest/gtest.h>

namespace sft::udp {
namespace {

using namespace std::chrono_literals;

class CongestionWindowTest : public testing::Test {
 protected:
  /// Handles a report of `position`, whose datagram waited in queues for `queueing`. The sender has sent
  /// 1000 bytes after that position.
  void hear(std::uint64_t position, std::chrono::milliseconds queueing, std::uint64_t reported = 0,
            std::size_t taken = 0) {
    FlowReport report{};
    report.position = position;
    window.hear(report, {.counted = true,
                         .queueing = queueing,
                         .reported = reported,
                         .sent = position + 1000,
                         .share = 10'000'000,
                         .taken = taken});
  }

  const FlowLimits limits{};
  CongestionWindow window{limits};
};

TEST_F(CongestionWindowTest, ShrinksOnceForALongQueue) {
  hear(5000, 5ms);
  const std::size_t smaller = limits.first_bytes / 10 * 7;
  EXPECT_EQ(window.bytes(), smaller);
  hear(6000, 5ms);
  EXPECT_EQ(window.bytes(), smaller) << "that was sent before";
  hear(6001, 5ms);
  EXPECT_LT(window.bytes(), smaller);
}

TEST_F(CongestionWindowTest, ShrinksNoFurtherThanWhatIsTakenWithoutALongQueue) {
  hear(5000, 5ms, 0, 1'000'000);
  EXPECT_EQ(window.bytes(), 1'000'000U);
  hear(10'000, 5ms, 5000, 20'000'000);
  EXPECT_EQ(window.bytes(), 1'000'000U) << "it does not grow either";
}

TEST_F(CongestionWindowTest, ShrinksWhereMuchIsLostHoweverMuchIsTaken) {
  FlowReport report{};
  report.position = 1000;
  report.datagrams = 100;
  window.hear(report, {.counted = true, .sent = 1000, .share = 1000, .taken = 20'000'000});
  EXPECT_EQ(window.bytes(), limits.first_bytes / 10 * 7);
}

TEST_F(CongestionWindowTest, NeverShrinksBelowTheLeast) {
  for (std::uint64_t i = 1; i < 50; ++i) hear(i * 10'000, 5ms);
  EXPECT_EQ(window.bytes(), limits.least_bytes);
  window.make_queue_short();
  EXPECT_EQ(window.bytes(), limits.least_bytes);
}

TEST_F(CongestionWindowTest, GrowsOnlyWhereItWasTheLimit) {
  hear(5000, 0ms);
  EXPECT_EQ(window.bytes(), limits.first_bytes);
  window.was_full(9000);
  hear(9000, 0ms, 5000);
  EXPECT_EQ(window.bytes(), limits.first_bytes + 4000) << "by what came since the report before";
  hear(9001, 0ms, 9000);
  EXPECT_EQ(window.bytes(), limits.first_bytes + 4000);
}

TEST_F(CongestionWindowTest, ShrinksWhereMoreThanATenthIsLost) {
  FlowReport report{};
  report.position = 1000;
  report.datagrams = 100;
  report.came = 89;
  window.hear(report, {.counted = true, .sent = 1000, .share = 1000});
  EXPECT_EQ(window.bytes(), limits.first_bytes) << "eleven may be lost";
  report.position = 2000;
  report.datagrams = 200;
  report.came = 177;
  window.hear(report, {.counted = true, .sent = 2000, .share = 1000});
  EXPECT_LT(window.bytes(), limits.first_bytes);
}

TEST_F(CongestionWindowTest, BeginsAnewOnAnotherWay) {
  hear(5000, 5ms);
  window.begin_anew();
  EXPECT_EQ(window.bytes(), limits.first_bytes);
}

}  // namespace
}  // namespace sft::udp
