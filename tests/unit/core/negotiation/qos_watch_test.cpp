// Deadlines and liveliness as functions of counts and times.
#include "core/negotiation/qos_watch.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/test_seed.h"
#include "tests/unit/core/start.h"

namespace sft::core {
namespace {

using namespace std::chrono_literals;
using Signs = OfferWatch::Signs;

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

// Looked at at its pace, whatever happens: what is told missed was missed, and what was missed for one and a
// half periods is told.
TEST(ActivityMonitorTest, NothingIsToldThatWasNotMissedAndNothingMissedForLongIsNotTold) {
  std::mt19937_64 random(test::test_seed());
  SCOPED_TRACE(test::how_to_repeat());
  ActivityMonitor monitor(100ms, 0, test_start);
  std::uint64_t count = 0;
  Time last_sign = test_start;
  Time next_sign = test_start;
  bool told = false;
  for (Time now = test_start; now < test_start + 60s; now += monitor.pace()) {
    while (next_sign <= now) {
      if (next_sign - last_sign > 150ms) {
        ASSERT_TRUE(told);
      }
      last_sign = next_sign;
      told = false;
      ++count;
      next_sign += std::chrono::milliseconds(random() % 300 + 1);
    }
    const std::uint64_t missed = monitor.look(count, now);
    told |= missed != 0;
    ASSERT_TRUE(missed == 0 || now - last_sign >= 100ms);
  }
}

TEST(OfferWatchTest, WithoutPromisesThereIsNothingToWatch) {
  OfferWatch watch({}, test_start);
  watch.look({}, test_start + 1h);
  EXPECT_EQ(watch.deadlines_missed(), 0U);
  EXPECT_TRUE(watch.alive());
  EXPECT_FALSE(watch.pace());
  EXPECT_FALSE(watch.assertion_due({}, false, test_start + 1h));
}

TEST(OfferWatchTest, ADeadlineIsMissedByNotPublishing) {
  OfferWatch watch({.deadline = 100ms}, test_start);
  EXPECT_EQ(watch.pace(), 50ms);
  watch.look({.published = 1}, test_start + 50ms);
  watch.look({.published = 1, .asserted = 5}, test_start + 150ms);
  EXPECT_EQ(watch.deadlines_missed(), 1U);
  EXPECT_TRUE(watch.alive());
}

TEST(OfferWatchTest, AManualWriterLivesByPublishingAndByAsserting) {
  OfferWatch watch({.liveliness = manual_by_topic, .liveliness_lease = 90ms}, test_start);
  watch.look({.published = 1}, test_start + 80ms);
  watch.look({.published = 1, .asserted = 1}, test_start + 160ms);
  watch.look({.published = 1, .asserted = 1}, test_start + 240ms);
  EXPECT_TRUE(watch.alive());
  watch.look({.published = 1, .asserted = 1}, test_start + 250ms);
  EXPECT_FALSE(watch.alive());
  watch.look({.published = 1, .asserted = 2}, test_start + 260ms);
  EXPECT_TRUE(watch.alive());
}

TEST(OfferWatchTest, AnAutomaticWriterIsAssertedThreeTimesInALease) {
  OfferWatch watch({.liveliness_lease = 90ms}, test_start);
  int sent = 0;
  for (auto t = 0ms; t < 900ms; t += 1ms) sent += watch.assertion_due({}, true, test_start + t) ? 1 : 0;
  EXPECT_EQ(sent, 30);
}

TEST(OfferWatchTest, ALeaseIsLookedAtSixTimesAndADeadlineTwiceInAPeriod) {
  EXPECT_EQ(OfferWatch({.liveliness_lease = 90ms}, test_start).pace(), 15ms);
  EXPECT_EQ(OfferWatch({.liveliness = manual_by_topic, .liveliness_lease = 90ms}, test_start).pace(), 15ms);
  EXPECT_EQ(OfferWatch({.deadline = 20ms, .liveliness_lease = 90ms}, test_start).pace(), 10ms);
  EXPECT_EQ(OfferWatch({.deadline = 80ms, .liveliness_lease = 90ms}, test_start).pace(), 15ms);
}

// Looked at at its pace an assertion is never later than that, and so never too late.
TEST(OfferWatchTest, AnAssertionOfTheProgramIsToldWithinHalfALeaseThoughAnotherWasJustTold) {
  OfferWatch watch({.liveliness = manual_by_topic, .liveliness_lease = 90ms}, test_start);
  ASSERT_TRUE(watch.assertion_due({.asserted = 1}, true, test_start));
  Time now = test_start + 1ms;  // the program asserts again
  while (!watch.assertion_due({.asserted = 2}, true, now)) now += *watch.pace();
  EXPECT_LE(now, test_start + 46ms);
}

TEST(OfferWatchTest, SamplesSpareAssertionsWhereEveryReaderGetsThem) {
  OfferWatch watch({.liveliness_lease = 90ms}, test_start);
  int told = 0, not_told = 0;
  for (std::uint64_t t = 0; t < 900; ++t) {
    const Signs signs{.published = t / 20};
    told += watch.assertion_due(signs, true, test_start + std::chrono::milliseconds(t)) ? 1 : 0;
  }
  OfferWatch limited({.liveliness_lease = 90ms}, test_start);
  for (std::uint64_t t = 0; t < 900; ++t) {
    const Signs signs{.published = t / 20};
    not_told += limited.assertion_due(signs, false, test_start + std::chrono::milliseconds(t)) ? 1 : 0;
  }
  EXPECT_LE(told, 1);
  EXPECT_EQ(not_told, 30);
}

TEST(OfferWatchTest, AManualWriterIsAssertedWhenTheProgramDidAndAtOnceIfThatIsRare) {
  OfferWatch watch({.liveliness = manual_by_topic, .liveliness_lease = 90ms}, test_start);
  EXPECT_FALSE(watch.assertion_due({}, true, test_start + 10ms));
  EXPECT_TRUE(watch.assertion_due({.asserted = 1}, true, test_start + 20ms));
  EXPECT_TRUE(watch.rests(test_start + 49ms));
  EXPECT_FALSE(watch.assertion_due({.asserted = 2}, true, test_start + 49ms));
  EXPECT_TRUE(watch.assertion_due({.asserted = 2}, true, test_start + 50ms)) << "it is not forgotten";
  EXPECT_FALSE(watch.assertion_due({.asserted = 2}, true, test_start + 500ms));
}

TEST(RequestWatchTest, AReaderThatAsksForNothingWatchesNothing) {
  const RequestWatch watch({.deadline = 1s, .liveliness_lease = 1s}, {}, 0, test_start);
  EXPECT_FALSE(watch.pace());
  EXPECT_TRUE(watch.alive());
}

TEST(RequestWatchTest, AnImpossibleLeaseIsReplacedByTheRequestedOne) {
  RequestWatch watch({.liveliness_lease = 1ns}, {.liveliness_lease = 1s}, 5, test_start);
  EXPECT_EQ(watch.pace(), 500ms);
  watch.look(5, test_start + 999ms);
  EXPECT_TRUE(watch.alive());
  watch.look(5, test_start + 1s);
  EXPECT_FALSE(watch.alive());
}

TEST(RequestWatchTest, DeadlinesAreTheReadersAndLeasesTheWriters) {
  RequestWatch watch({.deadline = 10ms, .liveliness_lease = 200ms},
                     {.deadline = 100ms, .liveliness_lease = 1s}, 5, test_start);
  EXPECT_EQ(watch.look(5, test_start + 100ms), 1U);
  EXPECT_TRUE(watch.alive());
  EXPECT_EQ(watch.look(5, test_start + 200ms), 1U);
  EXPECT_FALSE(watch.alive());
  watch.asserted();
  EXPECT_EQ(watch.look(5, test_start + 250ms), 0U);
  EXPECT_TRUE(watch.alive());
  EXPECT_EQ(watch.look(5, test_start + 300ms), 1U) << "an assertion is no sample";
  EXPECT_EQ(watch.look(6, test_start + 390ms), 0U);
}

}  // namespace
}  // namespace sft::core
