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
  bool is_full(bool is_calm = true, Time newcomer_at = {}) {
    return signs.is_due(life, is_calm, newcomer_at, now);
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

TEST_F(FullSignsTest, WhereDiscoveryIsNotCalmEachSignIsFull) {
  EXPECT_TRUE(is_full());
  EXPECT_TRUE(is_full(false));
  EXPECT_TRUE(is_full(false));
  EXPECT_FALSE(is_full());
}

TEST_F(FullSignsTest, ASignThatTellsMoreThanLifeIsFull) {
  is_full();
  life.writers = {5};
  EXPECT_TRUE(is_full());
}

TEST_F(FullSignsTest, ANewcomerHearsFullSignsForAWhile) {
  is_full();
  const Time newcomer_at = now;
  for (; now <= newcomer_at + 3s; now += 500ms) EXPECT_TRUE(is_full(true, newcomer_at));
  EXPECT_FALSE(is_full(true, newcomer_at));
}

TEST_F(FullSignsTest, ANodeThatIsForgottenBeginsAnew) {
  is_full();
  signs.forget(77);
  EXPECT_TRUE(is_full());
}

}  // namespace
}  // namespace sft::core
