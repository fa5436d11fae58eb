// Deadlines and liveliness are computed from counts and times only.
#include "core/negotiation/qos_monitor.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/test_seed.h"
#include "tests/unit/core/start.h"

namespace sft::core {
namespace {

using namespace std::chrono_literals;
using Signs = OfferMonitor::Signs;

TEST(ActivityMonitorTest, EveryPeriodWithoutASignIsMissedOnce) {
  ActivityMonitor monitor(100ms, 0, test_start);
  EXPECT_EQ(monitor.look(0, test_start + 99ms), 0U);
  EXPECT_FALSE(monitor.quiet());
  EXPECT_EQ(monitor.look(0, test_start + 100ms), 1U);
  EXPECT_EQ(monitor.look(0, test_start + 150ms), 0U);
  EXPECT_EQ(monitor.look(0, test_start + 420ms), 3U);
  EXPECT_TRUE(monitor.quiet());
}

TEST(ActivityMonitorTest, ASignBeginsANewPeriod) {
  ActivityMonitor monitor(100ms, 0, test_start);
  EXPECT_EQ(monitor.look(1, test_start + 90ms), 0U);
  EXPECT_EQ(monitor.look(1, test_start + 189ms), 0U);
  EXPECT_EQ(monitor.look(1, test_start + 190ms), 1U);
  EXPECT_EQ(monitor.look(7, test_start + 200ms), 0U);
  EXPECT_FALSE(monitor.quiet());
}

TEST(ActivityMonitorTest, ACountMayTurnOverOrBeginAgain) {
  ActivityMonitor monitor(100ms, UINT64_MAX, test_start);
  EXPECT_EQ(monitor.look(0, test_start + 90ms), 0U);
  EXPECT_EQ(monitor.look(0, test_start + 189ms), 0U);
}

// The monitor is called at its own pace, and signs of life come at random times. It reports only missed
// periods, and it always reports a missed period after one and a half periods without a sign.
TEST(ActivityMonitorTest, NothingIsToldThatWasNotMissedAndNothingMissedForLongIsNotTold) {
  std::mt19937_64 random(test::test_seed());
  SCOPED_TRACE(test::how_to_repeat());
  ActivityMonitor monitor(100ms, 0, test_start);
  std::uint64_t count = 0;
  Time last_sign = test_start;
  Time next_sign = test_start;
  bool reported = false;
  for (Time now = test_start; now < test_start + 60s; now += monitor.pace()) {
    while (next_sign <= now) {
      if (next_sign - last_sign > 150ms) {
        ASSERT_TRUE(reported);
      }
      last_sign = next_sign;
      reported = false;
      ++count;
      next_sign += std::chrono::milliseconds(random() % 300 + 1);
    }
    const std::uint64_t missed = monitor.look(count, now);
    reported |= missed != 0;
    ASSERT_TRUE(missed == 0 || now - last_sign >= 100ms);
  }
}

TEST(OfferMonitorTest, WithoutPromisesThereIsNothingToWatch) {
  OfferMonitor monitor({}, test_start);
  monitor.look({}, test_start + 1h);
  EXPECT_EQ(monitor.deadlines_missed(), 0U);
  EXPECT_TRUE(monitor.alive());
  EXPECT_FALSE(monitor.pace());
  EXPECT_FALSE(monitor.assertion_due({}, false, test_start + 1h));
}

TEST(OfferMonitorTest, ADeadlineIsMissedByNotPublishing) {
  OfferMonitor monitor({.deadline = 100ms}, test_start);
  EXPECT_EQ(monitor.pace(), 50ms);
  monitor.look({.published = 1}, test_start + 50ms);
  monitor.look({.published = 1, .asserted = 5}, test_start + 150ms);
  EXPECT_EQ(monitor.deadlines_missed(), 1U);
  EXPECT_TRUE(monitor.alive());
}

TEST(OfferMonitorTest, AManualWriterLivesByPublishingAndByAsserting) {
  OfferMonitor monitor({.liveliness = manual_by_topic, .liveliness_lease = 90ms}, test_start);
  monitor.look({.published = 1}, test_start + 80ms);
  monitor.look({.published = 1}, test_start + 150ms);
  EXPECT_TRUE(monitor.alive());
  monitor.look({.published = 1, .asserted = 1}, test_start + 160ms);
  monitor.look({.published = 1, .asserted = 1}, test_start + 240ms);
  EXPECT_TRUE(monitor.alive());
  monitor.look({.published = 1, .asserted = 1}, test_start + 250ms);
  EXPECT_FALSE(monitor.alive());
  monitor.look({.published = 1, .asserted = 2}, test_start + 260ms);
  EXPECT_TRUE(monitor.alive());
}

TEST(OfferMonitorTest, AnAutomaticWriterIsAssertedThreeTimesInALease) {
  OfferMonitor monitor({.liveliness_lease = 90ms}, test_start);
  int sent = 0;
  for (auto t = 0ms; t < 900ms; t += 1ms) sent += monitor.assertion_due({}, true, test_start + t) ? 1 : 0;
  EXPECT_EQ(sent, 30);
}

TEST(OfferMonitorTest, ALeaseIsLookedAtSixTimesAndADeadlineTwiceInAPeriod) {
  EXPECT_EQ(OfferMonitor({.liveliness_lease = 90ms}, test_start).pace(), 15ms);
  EXPECT_EQ(OfferMonitor({.liveliness = manual_by_topic, .liveliness_lease = 90ms}, test_start).pace(), 15ms);
  EXPECT_EQ(OfferMonitor({.deadline = 20ms, .liveliness_lease = 90ms}, test_start).pace(), 10ms);
  EXPECT_EQ(OfferMonitor({.deadline = 80ms, .liveliness_lease = 90ms}, test_start).pace(), 15ms);
}

// A monitor that is called at its own pace detects an assertion of the program in time.
TEST(OfferMonitorTest, AnAssertionOfTheProgramIsToldWithinHalfALeaseThoughAnotherWasJustTold) {
  OfferMonitor monitor({.liveliness = manual_by_topic, .liveliness_lease = 90ms}, test_start);
  ASSERT_TRUE(monitor.assertion_due({.asserted = 1}, true, test_start));
  Time now = test_start + 1ms;  // the program asserts again
  while (!monitor.assertion_due({.asserted = 2}, true, now)) now += *monitor.pace();
  EXPECT_LE(now, test_start + 46ms);
}

TEST(OfferMonitorTest, SamplesSpareAssertionsWhereEveryReaderGetsThem) {
  OfferMonitor monitor({.liveliness_lease = 90ms}, test_start);
  int reported = 0, not_reported = 0;
  for (std::uint64_t t = 0; t < 900; ++t) {
    const Signs signs{.published = t / 20};
    reported += monitor.assertion_due(signs, true, test_start + std::chrono::milliseconds(t)) ? 1 : 0;
  }
  OfferMonitor limited({.liveliness_lease = 90ms}, test_start);
  for (std::uint64_t t = 0; t < 900; ++t) {
    const Signs signs{.published = t / 20};
    not_reported += limited.assertion_due(signs, false, test_start + std::chrono::milliseconds(t)) ? 1 : 0;
  }
  EXPECT_LE(reported, 1);
  EXPECT_EQ(not_reported, 30);
}

TEST(OfferMonitorTest, AManualWriterIsAssertedWhenTheProgramDidAndAtOnceIfThatIsRare) {
  OfferMonitor monitor({.liveliness = manual_by_topic, .liveliness_lease = 90ms}, test_start);
  EXPECT_FALSE(monitor.assertion_due({}, true, test_start + 10ms));
  EXPECT_TRUE(monitor.assertion_due({.asserted = 1}, true, test_start + 20ms));
  EXPECT_TRUE(monitor.rests(test_start + 49ms));
  EXPECT_FALSE(monitor.assertion_due({.asserted = 2}, true, test_start + 49ms));
  EXPECT_TRUE(monitor.assertion_due({.asserted = 2}, true, test_start + 50ms)) << "it is not forgotten";
  EXPECT_FALSE(monitor.assertion_due({.asserted = 2}, true, test_start + 500ms));
}

TEST(RequestMonitorTest, AReaderThatAsksForNothingWatchesNothing) {
  const RequestMonitor monitor({.deadline = 1s, .liveliness_lease = 1s}, {}, 0, test_start);
  EXPECT_FALSE(monitor.pace());
  EXPECT_TRUE(monitor.alive());
}

TEST(RequestMonitorTest, AnImpossibleLeaseIsReplacedByTheRequestedOne) {
  RequestMonitor monitor({.liveliness_lease = 1ns}, {.liveliness_lease = 1s}, 5, test_start);
  EXPECT_EQ(monitor.pace(), 500ms);
  monitor.look(5, test_start + 999ms);
  EXPECT_TRUE(monitor.alive());
  monitor.look(5, test_start + 1s);
  EXPECT_FALSE(monitor.alive());
}

TEST(RequestMonitorTest, DeadlinesAreTheReadersAndLeasesTheWriters) {
  RequestMonitor monitor({.deadline = 10ms, .liveliness_lease = 200ms},
                         {.deadline = 100ms, .liveliness_lease = 1s}, 5, test_start);
  EXPECT_EQ(monitor.look(5, test_start + 100ms), 1U);
  EXPECT_TRUE(monitor.alive());
  EXPECT_EQ(monitor.look(5, test_start + 200ms), 1U);
  EXPECT_FALSE(monitor.alive());
  monitor.asserted();
  EXPECT_EQ(monitor.look(5, test_start + 250ms), 0U);
  EXPECT_TRUE(monitor.alive());
  EXPECT_EQ(monitor.look(5, test_start + 300ms), 1U) << "an assertion is no sample";
  EXPECT_EQ(monitor.look(6, test_start + 390ms), 0U);
}

}  // namespace
}  // namespace sft::core
