#include "udp_transport/reliable/repair_schedule.h"

#include <gtest/gtest.h>

namespace sft::udp {
namespace {

using namespace std::chrono_literals;
using Time = RepairSchedule::Time;

constexpr Time now{1h};

TEST(RepairScheduleTest, AsksAfterADelayAndThenAfterPausesThatDouble) {
  RepairSchedule schedule({.ask_after = 2ms, .ask_again_longest = 10ms});
  RepairSchedule::Entry entry = schedule.noticed(now);
  EXPECT_EQ(schedule.due(entry, Time{}), now + 2ms);
  EXPECT_EQ(schedule.ask(entry, now), now + 4ms);
  EXPECT_EQ(schedule.ask(entry, now), now + 8ms);
  EXPECT_EQ(schedule.ask(entry, now), now + 10ms);
}

TEST(RepairScheduleTest, WaitsAnewWheneverSomethingOfTheSampleComes) {
  RepairSchedule schedule({.ask_after = 2ms});
  RepairSchedule::Entry entry = schedule.noticed(now);
  EXPECT_EQ(schedule.due(entry, now + 5ms), now + 7ms);
  schedule.ask(entry, now + 7ms);
  schedule.ask(entry, now + 7ms);
  schedule.due(entry, now + 30ms);
  EXPECT_EQ(schedule.ask(entry, now + 32ms), now + 36ms) << "as if it was asked for the first time";
}

TEST(RepairScheduleTest, WaitsLongerOnceAllThatItAskedForCameAgainAndShorterWhereItComesOnce) {
  RepairSchedule schedule({.ask_after = 8ms});
  RepairSchedule::Entry entry = schedule.noticed(now);
  schedule.ask(entry, now);
  RepairSchedule::asked_for(entry, 2);
  schedule.came_again(entry);
  EXPECT_EQ(schedule.soon(now), now + 8ms) << "networks repeat some";
  schedule.came_again(entry);
  EXPECT_EQ(schedule.soon(now), now + 16ms);
  RepairSchedule::asked_for(entry, 1);
  schedule.came_whole(entry);
  EXPECT_EQ(schedule.soon(now), now + 14ms);
  for (int i = 0; i < 10; ++i) schedule.came_whole(entry);
  EXPECT_EQ(schedule.soon(now), now + 8ms) << "never less than at first";
}

TEST(RepairScheduleTest, WaitsNoLongerThanItsLongestDelay) {
  RepairSchedule schedule({.ask_after = 8ms});
  for (int i = 0; i < 10; ++i) {
    RepairSchedule::Entry entry{.parts = 1};
    schedule.came_again(entry);
  }
  EXPECT_EQ(schedule.soon(now), now + RepairSchedule::delay_longest);
}

TEST(RepairScheduleTest, LooksAtTheEarliestTimeButNotTooOftenAtManySamples) {
  RepairSchedule schedule({});
  EXPECT_EQ(schedule.next_look(), Time::max());
  schedule.begin_look(now);
  schedule.look_at(now + 100us, 1000);
  EXPECT_EQ(schedule.next_look(), now + 500us);
  schedule.look_at(now + 100us, 10);
  EXPECT_EQ(schedule.next_look(), now + 100us);
  schedule.look_at(now + 200us, 10);
  EXPECT_EQ(schedule.next_look(), now + 100us);
  schedule.nothing_is_missing();
  EXPECT_EQ(schedule.next_look(), Time::max());
}

TEST(RepairScheduleTest, IsStuckOnlyWhileTheWriterIsHeardAndNothingGetsFurther) {
  RepairSchedule schedule({.claim_patience = 300ms});
  EXPECT_FALSE(schedule.is_stuck(7, {}, now)) << "the first look begins the time";
  EXPECT_FALSE(schedule.is_stuck(7, {}, now + 300ms)) << "the writer was not heard";
  schedule.heard(now + 290ms);
  EXPECT_TRUE(schedule.is_stuck(7, {}, now + 300ms));
  EXPECT_FALSE(schedule.is_stuck(7, now + 200ms, now + 300ms)) << "the first missing one gets further";
  EXPECT_FALSE(schedule.is_stuck(8, {}, now + 300ms)) << "another one is the first missing one";
}

}  // namespace
}  // namespace sft::udp
