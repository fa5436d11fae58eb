// The watchdog of arrivals in simulated time. It restarts only connections over which nothing arrives.
#include "core/node/arrival_watchdog.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <vector>

#include "tests/support/test_seed.h"

namespace sft::core {
namespace {

using namespace std::chrono_literals;
using std::chrono::milliseconds;

class ArrivalWatchdogTest : public test::RandomTest {
 protected:
  struct Scene {
    std::chrono::microseconds period = 10ms;  ///< the time between samples, except between bursts
    std::uint64_t bytes = 1000;
    double lost = 0;  ///< the fraction of the samples that is lost
    double reports_lost = 0;
    std::chrono::milliseconds report_transit = 0ms;  ///< how old the progress in a report is on arrival
    std::chrono::milliseconds transit = 1ms;
    std::chrono::milliseconds jitter = 0ms;  ///< the maximum random time that is added to `transit`
    /// The number of samples in a burst; 0: no bursts. Each burst is followed by a pause of the same
    /// length.
    std::uint64_t burst = 0;
    ArrivalWatchdog::Pair pair{};
  };

  bool happens(double probability) { return std::uniform_real_distribution<>(0, 1)(random) < probability; }

  /// Simulates the events at the reader's agent for the duration `length`. The pair works as the scene
  /// describes. But if `hears_nothing` is true, the reader receives nothing.
  void run(const Scene& scene, std::chrono::nanoseconds length, bool hears_nothing = false) {
    const Time end = now + length;
    Time publish_at = now, passes_at = now;
    while (now < end) {
      now = std::min({publish_at, report_at, look_at});
      for (; !under_way.empty() && *under_way.begin() <= now; ++arrived) under_way.erase(under_way.begin());
      if (now == publish_at) {
        ++sent.samples;
        sent.bytes += scene.bytes;
        publish_at += scene.period;
        if (scene.burst != 0 && sent.samples % scene.burst == 0)
          publish_at += scene.period * static_cast<std::int64_t>(scene.burst);
        const bool passes = now >= passes_at;
        if (passes) passes_at = now + std::chrono::microseconds(scene.pair.min_period_us);
        if (!hears_nothing && passes && !happens(scene.lost)) {
          const auto late = std::chrono::milliseconds(
              std::uniform_int_distribution<std::int64_t>(0, scene.jitter.count())(random));
          under_way.insert(now + scene.transit + late);
        }
      }
      if (now == report_at) {
        report = sent;
        look_at = report_at + scene.report_transit;
        report_at += 650ms;
      }
      if (now == look_at) {
        look_at = Time::max();
        const bool is_news = report.samples != reported;
        reported = report.samples;
        if (happens(scene.reports_lost)) continue;
        if (watchdog.look(is_news ? &report : nullptr, arrived, scene.pair, now)) {
          restarted_at.push_back(now);
          arrived = 0;  // a new connection counts its arrivals from 0
        }
      }
    }
  }

  ArrivalWatchdog watchdog;
  Time now{1h};
  Time report_at{1h}, look_at = Time::max();
  Progress sent{1, 0, 0}, report{1, 0, 0};
  std::uint64_t reported = 0, arrived = 0;
  std::multiset<Time> under_way;
  std::vector<Time> restarted_at;
};

TEST_F(ArrivalWatchdogTest, APairAtWhichNothingArrivesAnyMoreIsRestartedWithinFiveSeconds) {
  for (const bool reliable : {false, true}) {
    for (const auto period : {1ms, 10ms, 30ms}) {
      restarted_at.clear();
      watchdog = {};
      const Scene scene{.period = period, .pair = {.reliable = reliable}};
      run(scene, 10s);
      ASSERT_TRUE(restarted_at.empty());
      const Time begin = now;
      run(scene, 5s, true);
      ASSERT_FALSE(restarted_at.empty()) << period.count();
      EXPECT_LE(restarted_at[0] - begin, 5s);
    }
  }
}

TEST_F(ArrivalWatchdogTest, APairAtWhichNothingEverArrivedIsRestarted) {
  run({}, 6s, true);
  EXPECT_FALSE(restarted_at.empty());
}

TEST_F(ArrivalWatchdogTest, APairThatStaysWithoutArrivalsIsRestartedEverMoreSeldomAndAMinuteApartInTheEnd) {
  run({}, 5s);
  run({}, 600s, true);
  ASSERT_GT(restarted_at.size(), 10U);
  for (std::size_t i = 1; i < restarted_at.size(); ++i) {
    const auto pause = restarted_at[i] - restarted_at[i - 1];
    const auto least =
        std::min<std::chrono::nanoseconds>(1s * (std::int64_t{1} << std::min<std::size_t>(i - 1, 10)), 60s);
    EXPECT_GE(pause, least) << i;
    EXPECT_LE(pause, std::max<std::chrono::nanoseconds>(least, 3s) + 1300ms) << i;
  }
  EXPECT_EQ(watchdog.restarts(), restarted_at.size());
}

TEST_F(ArrivalWatchdogTest, APairThatWorkedAgainIsRestartedSoonWhenNothingArrivesOnceMore) {
  run({}, 300s, true);
  run({}, 100s);
  const std::size_t before = restarted_at.size();
  const Time begin = now;
  run({}, 10s, true);
  ASSERT_GT(restarted_at.size(), before + 1);
  EXPECT_LE(restarted_at[before] - begin, 4s + 400ms);
  EXPECT_LE(restarted_at[before + 1] - restarted_at[before], 4s + 400ms) << "the pauses begin anew, too";
}

TEST_F(ArrivalWatchdogTest, TheProgressIsNeededOnceNothingHasArrivedForTwoSecondsAndForAMinuteMore) {
  EXPECT_FALSE(watchdog.needs_progress(now)) << "there is no connection";
  watchdog.look(nullptr, 1, {}, now);
  EXPECT_FALSE(watchdog.needs_progress(now + 1999ms));
  EXPECT_TRUE(watchdog.needs_progress(now + 2s));
  watchdog.look(nullptr, 2, {}, now + 61s);
  EXPECT_TRUE(watchdog.needs_progress(now + 62s - 1ms));
  EXPECT_FALSE(watchdog.needs_progress(now + 62s));
  EXPECT_TRUE(watchdog.needs_progress(now + 63s));
}

TEST_F(ArrivalWatchdogTest, AQuietPairIsLeftAlone) {
  run({}, 10s);
  for (int i = 0; i < 1000; ++i) EXPECT_FALSE(watchdog.look(nullptr, arrived, {}, now += 650ms));
  run({}, 10s);
  EXPECT_TRUE(restarted_at.empty());
}

/// In each random scene the pair works, so it must not be restarted.
TEST_F(ArrivalWatchdogTest, APairThatWorksIsLeftAloneHoweverSlowLossyOrLimitedItIs) {
  const auto up_to = [this](std::int64_t most) {
    return std::uniform_int_distribution<std::int64_t>(0, most)(random);
  };
  for (int round = 0; round < 50; ++round) {
    watchdog = {};
    under_way.clear();
    look_at = Time::max();  // a report of the last scene does not come in this one
    Scene scene;
    scene.pair.reliable = up_to(1) == 0;
    scene.period = std::chrono::microseconds(std::int64_t{500} << up_to(13));  // 0.5 ms to 4 s
    scene.bytes = std::uint64_t{100} << up_to(16);
    scene.lost = scene.pair.reliable ? 0 : 0.2;
    scene.reports_lost = up_to(1) == 0 ? 0 : 0.2;
    // The link is as slow as the watchdog allows.
    scene.transit = milliseconds(scene.bytes * 1000 / ArrivalWatchdog::slowest_bytes_per_s + 1);
    scene.jitter = milliseconds(up_to(700));
    scene.report_transit = milliseconds(up_to(400));
    scene.burst = up_to(2) == 0 ? static_cast<std::uint64_t>(1 + up_to(100)) : 0;
    scene.pair.min_period_us = up_to(1) == 0 ? 0 : static_cast<std::uint32_t>(1000U << up_to(13));
    run(scene, std::clamp<std::chrono::nanoseconds>(scene.period * 20'000, 30s, 300s));
    ASSERT_TRUE(restarted_at.empty())
        << "round " << round << ": period " << scene.period.count() << " us, " << scene.bytes
        << " bytes, reliable " << scene.pair.reliable << ", limit " << scene.pair.min_period_us
        << " us, burst " << scene.burst;
  }
}

/// What a report says was true when the report left. Samples that were sent later have arrived earlier.
TEST_F(ArrivalWatchdogTest, APairThatIsQuickBetweenPausesIsLeftAloneAlthoughReportsAreOlderThanArrivals) {
  const Scene scene{
      .period = 500us, .report_transit = 5ms, .burst = 12'000, .pair = {.reliable = true}};  // 6 s each
  run(scene, 600s);
  EXPECT_TRUE(restarted_at.empty());
}

TEST_F(ArrivalWatchdogTest, AReportThatLeftBeforeTheLastArrivalDoesNotCount) {
  const ArrivalWatchdog::Pair pair{.reliable = true};
  const Progress older{1, 1990, 0}, newer{1, 2000, 0};
  EXPECT_FALSE(watchdog.look(nullptr, 1000, pair, now));
  EXPECT_FALSE(watchdog.look(nullptr, 2000, pair, now += 900ms)) << "all samples have arrived";
  EXPECT_FALSE(watchdog.look(&older, 2000, pair, now += 5ms));
  EXPECT_FALSE(watchdog.look(&newer, 2000, pair, now += 900ms));
  for (int i = 0; i < 5; ++i) EXPECT_FALSE(watchdog.look(nullptr, 2000, pair, now += 900ms));
}

/// A process that was stopped receives nothing. It first gets the time to receive what waits for it.
TEST_F(ArrivalWatchdogTest, ANodeThatWasStoppedGivesItsConnectionsTheirTimeAgain) {
  run({}, 10s);
  run({}, 3900ms, true);
  ASSERT_TRUE(restarted_at.empty());
  report_at = look_at = now += 10s;
  run({}, 1500ms, true);
  EXPECT_TRUE(restarted_at.empty());
  run({}, 5s, true);
  EXPECT_FALSE(restarted_at.empty());
}

TEST_F(ArrivalWatchdogTest, ReportsThatLeftWhileTheNodeWasStoppedDoNotCount) {
  const ArrivalWatchdog::Pair pair{.reliable = true};
  const Progress older{1, 1990, 0}, newer{1, 2000, 0};
  EXPECT_FALSE(watchdog.look(nullptr, 1000, pair, now));
  EXPECT_FALSE(watchdog.look(&older, 2000, pair, now += 10s)) << "all samples have arrived";
  EXPECT_FALSE(watchdog.look(&newer, 2000, pair, now += 5ms));
  for (int i = 0; i < 5; ++i) EXPECT_FALSE(watchdog.look(nullptr, 2000, pair, now += 900ms));
}

TEST_F(ArrivalWatchdogTest, ALossOfAllForAMomentIsNoReason) {
  run({}, 10s);
  for (int i = 0; i < 20; ++i) {
    run({}, 1s, true);
    run({}, 1s);
  }
  EXPECT_TRUE(restarted_at.empty());
}

TEST_F(ArrivalWatchdogTest, WhatIsExcusedCountsFromThenOn) {
  run({}, 10s);
  for (int i = 0; i < 20; ++i) {
    run({}, 1s, true);
    watchdog.excuse();
  }
  EXPECT_TRUE(restarted_at.empty());
  run({}, 5s, true);
  EXPECT_FALSE(restarted_at.empty());
}

TEST_F(ArrivalWatchdogTest, WhoAwaitsHistoryIsGivenMoreTimeAndNotForEver) {
  const Scene scene{.pair = {.reliable = true, .awaits_history = true}};
  run(scene, 9s, true);
  EXPECT_TRUE(restarted_at.empty());
  run(scene, 6s, true);
  EXPECT_FALSE(restarted_at.empty());
}

}  // namespace
}  // namespace sft::core
