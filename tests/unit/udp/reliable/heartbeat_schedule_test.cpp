#include "udp_transport/reliable/heartbeat_schedule.h"

#include <gtest/gtest.h>

namespace sft::udp {
namespace {

using namespace std::chrono_literals;
using Kept = HeartbeatSchedule::Kept;
using Time = HeartbeatSchedule::Time;

class HeartbeatScheduleTest : public testing::Test {
 protected:
  /// Sends a sample and the first heartbeat. The receiver answers this heartbeat.
  void begin() {
    schedule.sent(true, Kept::at_most_half, now);
    EXPECT_TRUE(schedule.take(Kept::at_most_half, now));
    schedule.answered(Kept::at_most_half, now);
  }

  const ResendLimits limits{};
  const Time now{1h};
  HeartbeatSchedule schedule{limits};
};

TEST_F(HeartbeatScheduleTest, BeginsWithTheFirstSample) {
  EXPECT_EQ(schedule.next(), Time::max());
  schedule.sent(true, Kept::at_most_half, now);
  EXPECT_EQ(schedule.next(), now);
  EXPECT_TRUE(schedule.take(Kept::at_most_half, now));
  EXPECT_FALSE(schedule.take(Kept::at_most_half, now));
}

TEST_F(HeartbeatScheduleTest, FallsSilentOnceNothingIsKept) {
  begin();
  schedule.answered(Kept::nothing, now);
  EXPECT_EQ(schedule.next(), Time::max());
  schedule.way_changed(Kept::nothing, now);
  EXPECT_EQ(schedule.next(), Time::max());
}

TEST_F(HeartbeatScheduleTest, ComesEverMoreSeldomWhileNobodyAnswers) {
  schedule.sent(true, Kept::at_most_half, now);
  Time at = now;
  for (const auto pause : {40ms, 80ms, 160ms, 320ms, 640ms, 1000ms, 1000ms}) {
    ASSERT_TRUE(schedule.take(Kept::at_most_half, at));
    EXPECT_EQ(schedule.next(), at + pause);
    at = schedule.next();
  }
  EXPECT_EQ(schedule.unanswered(), 7);
}

TEST_F(HeartbeatScheduleTest, ComesSoonBehindTheLastSampleOnALinkThatLoses) {
  begin();
  schedule.lost(now);
  schedule.sent(true, Kept::at_most_half, now + 100ms);
  EXPECT_EQ(schedule.next(), now + 100ms + limits.heartbeat_delay);
}

TEST_F(HeartbeatScheduleTest, WaitsForTwiceTheUsualPauseBetweenSamples) {
  begin();
  schedule.sent(true, Kept::at_most_half, now + 100ms);
  EXPECT_EQ(schedule.next(), now + 300ms);
  schedule.sent(false, Kept::at_most_half, now + 150ms);
  EXPECT_EQ(schedule.next(), now + 350ms) << "a repair tells nothing of the usual pause";
}

TEST_F(HeartbeatScheduleTest, AMuchLongerPauseBetweenTwoSamplesHardlyCountsAsUsual) {
  begin();
  schedule.sent(true, Kept::at_most_half, now + 40ms);  // after the usual pause
  const Time after_pause = now + 40ms + 10s;
  schedule.sent(true, Kept::at_most_half, after_pause);
  ASSERT_TRUE(schedule.take(Kept::at_most_half, schedule.next()));
  schedule.answered(Kept::at_most_half, after_pause);
  schedule.sent(true, Kept::at_most_half, after_pause + 45ms);
  EXPECT_EQ(schedule.next(), after_pause + 3 * 45ms);
}

TEST_F(HeartbeatScheduleTest, DoesNotWaitForTheLastSampleWhileMuchIsKept) {
  begin();
  schedule.sent(true, Kept::more_than_half, now + 100ms);
  EXPECT_EQ(schedule.next(), now + limits.heartbeat_pause);
}

TEST_F(HeartbeatScheduleTest, ComesSoonWhereTheOtherEndNeedsItButNotTooOften) {
  begin();
  schedule.want_soon(Kept::at_most_half, now + 5ms);
  EXPECT_EQ(schedule.next(), now + limits.heartbeat_delay);
}

TEST_F(HeartbeatScheduleTest, ComesAtOnceWhereTheWayHasChanged) {
  begin();
  schedule.way_changed(Kept::at_most_half, now + 1ms);
  EXPECT_TRUE(schedule.take(Kept::at_most_half, now + 1ms));
}

}  // namespace
}  // namespace sft::udp
