// A pulse will do for a sign of life unless somebody needs more.
#include "core/discovery/full_signs.h"

#include <gtest/gtest.h>

#include "core/discovery/leases.h"
#include "core/node/tick_pace.h"

namespace sft::core {
namespace {

using namespace std::chrono_literals;

class FullSignsTest : public ::testing::Test {
 protected:
  bool is_full(bool is_wanted = false, Time newcomer_at = {}) {
    return signs.is_due(life, is_wanted, newcomer_at, now);
  }

  FullSigns signs;
  Assertion life{.node = 77, .writers = {}};
  Time now{1000s};
};

TEST(LifeSignsByPulses, AreHeardWithEachLookBeforeTheirSpeakerCountsAsSilent) {
  EXPECT_LT(life_signs_by_pulses.pause_in_calm, silence_in(lease_default));
  EXPECT_LT(TickPace::pause_in_calm, silence_in(lease_default));
}

TEST_F(FullSignsTest, TheFirstSignOfANodeIsFull) {
  EXPECT_TRUE(is_full());
  EXPECT_FALSE(is_full());
  life.node = 78;
  EXPECT_TRUE(is_full()) << "another node";
}

TEST_F(FullSignsTest, InCalmOneOfManySignsIsFullBeforeCyclonesLeaseEnds) {
  int full = 0, all = 0;
  for (const Time end = now + 300s; now < end; now += life_signs_by_pulses.pause_in_calm, ++all)
    full += is_full() ? 1 : 0;
  EXPECT_GE(full, 300s / (full_sign_lease / 3)) << "two full signs may get lost";
  EXPECT_LE(full, all / 7);
}

TEST_F(FullSignsTest, WhereFrequentSignsAreWantedEachIsFull) {
  EXPECT_TRUE(is_full());
  EXPECT_TRUE(is_full(true));
  EXPECT_TRUE(is_full(true));
  EXPECT_FALSE(is_full());
}

TEST_F(FullSignsTest, ASignThatTellsMoreThanLifeIsFull) {
  is_full();
  life.writers = {5};
  EXPECT_TRUE(is_full());
}

TEST_F(FullSignsTest, ANewcomerHearsAFullSignAtOnceAndSeveralMore) {
  constexpr auto between = 1200ms;
  for (const auto pause : {500ms, life_signs_by_pulses.pause, life_signs_by_pulses.pause_in_calm}) {
    now += 100s;
    is_full();
    now += 10s;
    const Time newcomer_at = now;
    EXPECT_TRUE(is_full(false, newcomer_at));
    Time last = now;
    int full = 1;
    for (now += pause; now <= newcomer_at + 3s; now += pause) {
      if (!is_full(false, newcomer_at)) continue;
      EXPECT_LT(now - last, between + pause) << "one of them may get lost";
      last = now;
      ++full;
    }
    EXPECT_LT(now - last, between + 2 * pause);
    EXPECT_GE(full, 2) << pause.count() << " ms";
    EXPECT_LE(full, 3) << "each wakes everybody, and there may be a crowd of newcomers";
    EXPECT_FALSE(is_full(false, newcomer_at));
  }
}

TEST_F(FullSignsTest, ANewcomerThatWasBusyHearsOneMoreLater) {
  const Time newcomer_at = now;
  for (; now <= newcomer_at + 3s; now += life_signs_by_pulses.pause_in_calm) is_full(false, newcomer_at);
  int full = 0;
  for (; now <= newcomer_at + 30s; now += life_signs_by_pulses.pause_in_calm)
    if (is_full(false, newcomer_at) && now <= newcomer_at + 8s) ++full;
  EXPECT_GE(full, 1);
  EXPECT_LE(full, 2);
}

TEST_F(FullSignsTest, ANewcomerHearsOneAtOnceUnlessOneWasGivenJustBefore) {
  is_full();
  now += life_signs_by_pulses.pause;
  EXPECT_FALSE(is_full(false, now)) << "the newcomer may have heard that one, or hears the next one";
  now += life_signs_by_pulses.pause;
  EXPECT_TRUE(is_full(false, now));
  now += 10s;
  EXPECT_TRUE(is_full(false, now));
}

TEST_F(FullSignsTest, AllNodesBeginAnewWhereALinkHasHadNoneYet) {
  is_full();
  signs.begin_anew();
  EXPECT_TRUE(is_full());
}

class FullSignsBegin : public ::testing::Test {
 protected:
  const Time opened{1000s};
};

TEST_F(FullSignsBegin, AtOnceWhereNodesAreFew) {
  EXPECT_LE(full_signs_begin_at(opened, {}, 0), opened + 100ms);
  EXPECT_LE(full_signs_begin_at(opened, opened + 20ms, 1), opened + 200ms);
}

TEST_F(FullSignsBegin, WhenACrowdHasMetEverybody) {
  constexpr std::size_t others = 64;
  for (auto met = opened; met < opened + 3s; met += 100ms)
    EXPECT_GT(full_signs_begin_at(opened, met, others), met + 1s) << "more may be on their way";
  EXPECT_LE(full_signs_begin_at(opened, opened + 1s, others), opened + 4s);
}

TEST_F(FullSignsBegin, InTheEndThoughNodesComeAndGoWithoutEnd) {
  EXPECT_LE(full_signs_begin_at(opened, opened + 1h, 1), opened + 3s);
  EXPECT_LE(full_signs_begin_at(opened, opened + 1h, 64), opened + 6s);
  EXPECT_LE(full_signs_begin_at(opened, opened + 1h, 1'000'000), opened + 14s) << "most are made up";
}

TEST_F(FullSignsTest, ANodeThatIsForgottenBeginsAnew) {
  is_full();
  signs.forget(77);
  EXPECT_TRUE(is_full());
}

}  // namespace
}  // namespace sft::core
