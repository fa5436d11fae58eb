// Signs of life are frequent while one of them matters to somebody, and seldom in calm.
#include "core/discovery/sign_pace.h"

#include <gtest/gtest.h>

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
  EXPECT_FALSE(pace.wants());
}

TEST_F(SignPaceTest, IsNotCalmForAWhileAfterNewsOfOurs) {
  pace.told_news(now);
  EXPECT_FALSE(pace.is_calm(now + 2999ms));
  EXPECT_TRUE(pace.is_calm(now + 3s));
}

TEST_F(SignPaceTest, WhoeverIsAskedForFrequentSignsDoesNotAskTheNextOne) {
  pace.others_want(now);
  EXPECT_FALSE(pace.is_calm(now + 29s));
  EXPECT_FALSE(pace.wants()) << "or one wish would go round for ever";
  EXPECT_TRUE(pace.is_calm(now + 30s));
}

TEST_F(SignPaceTest, AWishOfOursHoldsForOurselvesAndLongerThanItsReason) {
  pace.want(true, now);
  EXPECT_TRUE(pace.wants());
  EXPECT_FALSE(pace.is_calm(now));
  pace.want(false, now + 1s);
  EXPECT_FALSE(pace.wants());
  EXPECT_FALSE(pace.is_calm(now + 29s));
  EXPECT_TRUE(pace.is_calm(now + 30s));
}

}  // namespace
}  // namespace sft::core
