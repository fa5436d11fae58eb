#include "udp_transport/reliable/repair_schedule.h"

#include <gtest/gtest.h>

#include "tests/unit/udp/start.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;
using Time = RepairSchedule::Time;

TEST(RepairScheduleTest, AsksAfterADelayAndThenAfterPausesThatDouble) {
  RepairSchedule schedule({.ask_after = 2ms, .ask_again_longest = 10ms});
  RepairSchedule::Entry entry = schedule.noticed(test_start);
  EXPECT_EQ(schedule.due(entry, Time{}), test_start + 2ms);
  EXPECT_EQ(schedule.ask(entry, test_start), test_start + 4ms);
  EXPECT_EQ(schedule.ask(entry, test_start), test_start + 8ms);
  EXPECT_EQ(schedule.ask(entry, test_start), test_start + 10ms);
}

TEST(RepairScheduleTest, WaitsAnewWheneverSomethingOfTheSampleComes) {
  RepairSchedule schedule({.ask_after = 2ms});
  RepairSchedule::Entry entry = schedule.noticed(test_start);
  EXPECT_EQ(schedule.due(entry, test_start + 5ms), test_start + 7ms);
  schedule.ask(entry, test_start + 7ms);
  schedule.ask(entry, test_start + 7ms);
  schedule.due(entry, test_start + 30ms);
  EXPECT_EQ(schedule.ask(entry, test_start + 32ms), test_start + 36ms)
      << "as if it was asked for the first time";
}

TEST(RepairScheduleTest, WaitsLongerOnceAllThatItAskedForCameAgainAndShorterWhereItComesOnce) {
  RepairSchedule schedule({.ask_after = 8ms});
  RepairSchedule::Entry entry = schedule.noticed(test_start);
  schedule.ask(entry, test_start);
  RepairSchedule::asked_for(entry, 2);
  schedule.came_again(entry);
  EXPECT_EQ(schedule.soon(test_start), test_start + 8ms) << "networks repeat some";
  schedule.came_again(entry);
  EXPECT_EQ(schedule.soon(test_start), test_start + 16ms);
  RepairSchedule::asked_for(entry, 1);
  schedule.came_whole(entry);
  EXPECT_EQ(schedule.soon(test_start), test_start + 14ms);
  for (int i = 0; i < 10; ++i) schedule.came_whole(entry);
  EXPECT_EQ(schedule.soon(test_start), test_start + 8ms) << "never less than at first";
}

TEST(RepairScheduleTest, WaitsNoLongerThanItsLongestDelay) {
  RepairSchedule schedule({.ask_after = 8ms});
  for (int i = 0; i < 10; ++i) {
    RepairSchedule::Entry entry{.parts = 1};
    schedule.came_again(entry);
  }
  EXPECT_EQ(schedule.soon(test_start), test_start + RepairSchedule::delay_longest);
}

TEST(RepairScheduleTest, LooksAtTheEarliestTimeButNotTooOftenAtManySamples) {
  RepairSchedule schedule({});
  EXPECT_EQ(schedule.next_look(), Time::max());
  schedule.begin_look(test_start);
  schedule.look_at(test_start + 100us, 1000);
  EXPECT_EQ(schedule.next_look(), test_start + 500us);
  schedule.look_at(test_start + 100us, 10);
  EXPECT_EQ(schedule.next_look(), test_start + 100us);
  schedule.look_at(test_start + 200us, 10);
  EXPECT_EQ(schedule.next_look(), test_start + 100us);
  schedule.nothing_is_missing();
  EXPECT_EQ(schedule.next_look(), Time::max());
}

TEST(RepairScheduleTest, IsStuckOnlyWhileTheWriterIsHeardAndNothingGetsFurther) {
  RepairSchedule schedule({.confirm_timeout = 300ms});
  EXPECT_FALSE(schedule.is_stuck(7, {}, test_start)) << "the first look begins the time";
  EXPECT_FALSE(schedule.is_stuck(7, {}, test_start + 300ms)) << "the writer was not heard";
  schedule.heard(test_start + 290ms);
  EXPECT_TRUE(schedule.is_stuck(7, {}, test_start + 300ms));
  EXPECT_FALSE(schedule.is_stuck(7, test_start + 200ms, test_start + 300ms))
      << "the first missing one gets further";
  EXPECT_FALSE(schedule.is_stuck(8, {}, test_start + 300ms)) << "another one is the first missing one";
}

}  // namespace
}  // namespace sft::udp
