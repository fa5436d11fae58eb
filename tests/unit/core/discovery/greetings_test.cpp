#include "core/discovery/greetings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

namespace sft::core {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;

class GreetingsTest : public ::testing::Test {
 protected:
  /// Milliseconds since the start at which there was a greeting, in the next so many.
  std::vector<int> within(std::chrono::milliseconds duration, bool somebody_is_missing = false) {
    std::vector<int> times;
    for (const auto end = now + duration; now < end; now += 10ms) {
      if (greetings.due(now, somebody_is_missing)) times.push_back(static_cast<int>((now - start) / 1ms));
    }
    return times;
  }
  const Time start{};
  Time now = start;
  Greetings greetings{start};
};

TEST_F(GreetingsTest, AreManyAtFirstAndNoneLater) {
  EXPECT_THAT(within(100s), ElementsAre(40, 190, 790, 3160)) << "looked for every 10 ms";
}

TEST_F(GreetingsTest, AreDueWhenTheNextOneWasSaidToBe) {
  std::vector<int> times;
  while (greetings.next() != Time::max() && times.size() < 100) {
    now = greetings.next();
    times.push_back(static_cast<int>((now - start) / 1ms));
    ASSERT_TRUE(greetings.due(now, false));
  }
  EXPECT_THAT(times, ElementsAre(37, 185, 777, 3145));
}

TEST_F(GreetingsTest, SayThatANewcomerIsToBeGreeted) {
  within(100s);
  ASSERT_EQ(greetings.next(), Time::max());
  greetings.newcomer(now);
  EXPECT_EQ(greetings.next(), now + 100ms);
  within(200ms);
  EXPECT_EQ(greetings.next(), Time::max());
}

TEST_F(GreetingsTest, ComeWithinASecondOfWhenSomebodyIsMissedHoweverLongThePauseIs) {
  within(2s);  // the next one comes at 3160 ms
  EXPECT_THAT(within(500ms, true), ElementsAre(2000));
  within(3s);
  EXPECT_THAT(within(2s, true), ElementsAre(5500, 6500));
}

TEST_F(GreetingsTest, GoOnEachSecondWhileSomebodyIsMissing) {
  within(100s);
  EXPECT_EQ(within(32s, true).size(), 32U);
  EXPECT_TRUE(within(32s, false).empty());
}

TEST_F(GreetingsTest, FollowANewcomerSoonAndACrowdOfThemOnceASecond) {
  within(100s);
  greetings.newcomer(now);
  EXPECT_THAT(within(10s), ElementsAre(100'100));
  std::size_t greeted = 0;
  for (int i = 0; i < 100; ++i) {
    greetings.newcomer(now);
    greeted += within(50ms).size();
  }
  greeted += within(10s).size();
  EXPECT_GE(greeted, 5U);
  EXPECT_LE(greeted, 6U);
}

TEST_F(GreetingsTest, OfACrowdAreRareWhileItMeetsButForTheFirst) {
  greetings.others(64);
  greetings.newcomer(now);
  EXPECT_THAT(within(4s), ElementsAre(40, 2560));
  greetings.newcomer(now);
  EXPECT_THAT(within(10s), ElementsAre(5080, 7600)) << "none is left out";
  greetings.begin(now);
  EXPECT_EQ(within(50ms).size(), 1U) << "others may have forgotten us";
}

TEST_F(GreetingsTest, OfACrowdThatIsMadeUpStillCome) {
  greetings.others(1'000'000);
  EXPECT_EQ(within(10s).size(), 2U);
}

TEST_F(GreetingsTest, FollowPulsesOfStrangersAndBecomeRarerAsLongAsTheseAreHeard) {
  within(100s);
  std::vector<int> times;
  for (int i = 0; i < 400; ++i) {
    greetings.stranger(now);
    const std::vector<int> greeted = within(1s);
    for (const int at : greeted) times.push_back(at / 1000 - 100);
  }
  EXPECT_THAT(times, ElementsAre(3, 9, 21, 45, 93, 153, 213, 273, 333, 393));
}

TEST_F(GreetingsTest, AreNotDueToAStrangerWhoIsKnownSoonOrHeardOnce) {
  within(100s);
  greetings.stranger(now);
  within(1s);
  greetings.stranger(now);
  EXPECT_TRUE(within(100s).empty());
  greetings.stranger(now);
  EXPECT_TRUE(within(100s).empty()) << "the stranger before is forgotten";
}

TEST_F(GreetingsTest, BeginAnewWhenOthersMayBeReached) {
  within(100s);
  greetings.begin(now);
  EXPECT_EQ(within(100s).size(), 4U);
}

}  // namespace
}  // namespace sft::core
