// Signs of life are frequent while one of them matters to somebody, and seldom in calm.
#include "core/discovery/sign_pace.h"

#include <gtest/gtest.h>

#include "core/discovery/life_signs.h"
#include "core/node/tick_pace.h"

namespace sft::core {
namespace {

using namespace std::chrono_literals;

class SignPaceTest : public ::testing::Test {
 protected:
  SignPace pace;
  Time now{1000s};
};

TEST_F(SignPaceTest, IsCalmWhereNothingHasHappened) {
  EXPECT_TRUE(pace.is_calm(now));
  EXPECT_FALSE(pace.wants(now));
}

TEST_F(SignPaceTest, IsNotCalmForAWhileAfterNewsOfOurs) {
  pace.told_news(now);
  EXPECT_FALSE(pace.is_calm(now + 2999ms));
  EXPECT_TRUE(pace.is_calm(now + 3s));
}

TEST_F(SignPaceTest, WhoeverIsAskedForFrequentSignsDoesNotAskTheNextOne) {
  pace.others_want(now);
  EXPECT_FALSE(pace.is_calm(now + 2999ms));
  EXPECT_FALSE(pace.wants(now)) << "or one wish would go round for ever";
  EXPECT_TRUE(pace.is_calm(now + 3s));
}

TEST_F(SignPaceTest, FullSignsAreWantedWhileSomebodyAsksForFrequentOnesAndNotBecauseOfNews) {
  pace.told_news(now);
  EXPECT_FALSE(pace.are_wanted(now));
  pace.others_want(now);
  EXPECT_TRUE(pace.are_wanted(now + 2999ms));
  EXPECT_FALSE(pace.are_wanted(now + 3s));
  pace.want_after_doubt(now + 10s);
  EXPECT_TRUE(pace.are_wanted(now + 10s));
}

/// Signs are given at the first tick after each pause.
TEST_F(SignPaceTest, WhereASignWasLateOthersAreNotCalmForAsLongThoughThreeSignsInARowGetLost) {
  for (const LifeSigns& signs : {life_signs_to_all, life_signs_to_each}) {
    SignPace ours(signs), others(signs);
    ours.want_after_late_sign(now);
    others.others_want(now);
    int given = 0;
    Time next = now;
    for (Time at = now; at < now + 30s; at += 1ms) {
      if (at >= next) {
        next = at + signs.pause + TickPace::pause;
        if (given++ % 4 == 0 && ours.wants(at)) others.others_want(at);
      }
      ASSERT_FALSE(others.is_calm(at)) << (at - now) / 1ms << " ms";
    }
    EXPECT_TRUE(others.is_calm(now + 30s + others.repeated_for()));
  }
}

TEST_F(SignPaceTest, AWishOfOursHoldsForOurselvesAndLongerThanItsReason) {
  pace.want_after_doubt(now);
  EXPECT_TRUE(pace.wants(now + 2999ms));
  EXPECT_FALSE(pace.is_calm(now + 2999ms));
  EXPECT_FALSE(pace.wants(now + 3s));
  EXPECT_TRUE(pace.is_calm(now + 3s));
}

TEST_F(SignPaceTest, ANetworkThatLosesSignsIsNotCalmForHalfAMinute) {
  pace.want_after_late_sign(now);
  pace.want_after_doubt(now + 1s);
  EXPECT_TRUE(pace.wants(now + 29s)) << "a doubt does not end the wish";
  EXPECT_FALSE(pace.is_calm(now + 29s));
  EXPECT_TRUE(pace.is_calm(now + 30s));
}

}  // namespace
}  // namespace sft::core
