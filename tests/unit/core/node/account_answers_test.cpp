// About what others are told, and for how long.
#include "core/node/account_answers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/core/start.h"

namespace sft::core {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

class AccountAnswersTest : public ::testing::Test {
 protected:
  AccountAnswers answers{3s};
};

TEST_F(AccountAnswersTest, AreGivenAsLongAsSomebodyGoesOnAsking) {
  EXPECT_THAT(answers.asked_about(test_start), IsEmpty());
  answers.asked(7, test_start);
  answers.asked(8, test_start);
  answers.asked(7, test_start + 2s);
  EXPECT_THAT(answers.asked_about(test_start + 3s - 1ms), ElementsAre(7, 8));
  EXPECT_THAT(answers.asked_about(test_start + 3s), ElementsAre(7));
  EXPECT_THAT(answers.asked_about(test_start + 5s), IsEmpty());
}

TEST_F(AccountAnswersTest, OfAnEndpointThatIsGoneAreNotGiven) {
  answers.asked(7, test_start);
  answers.removed(7);
  EXPECT_THAT(answers.asked_about(test_start), IsEmpty());
}

TEST_F(AccountAnswersTest, BeyondWhatASignOfLifeHasRoomForAreGivenInTurns) {
  std::set<AccountId> all;
  for (EndpointId reader = 1; reader <= 50; ++reader) all.insert({{1000, reader}, Role::writer});
  std::set<AccountId> told;
  for (std::size_t i = 0; i < 2; ++i) {
    const std::vector<AccountId> next = answers.take_turns(all);
    EXPECT_EQ(next.size(), accounts_max);
    told.insert(next.begin(), next.end());
  }
  EXPECT_EQ(told, all) << "two signs tell of fifty pairs";
}

}  // namespace
}  // namespace sft::core
