#include "udp_transport/send/local_turns.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

namespace sft::udp {
namespace {

using namespace std::chrono_literals;

class LocalTurnsTest : public testing::Test {
 protected:
  LocalTurns turns;
  LocalTurns::Time now{1h};
};

TEST_F(LocalTurnsTest, AreNotDueWhereNobodyPublishesToReadersOnThisHost) {
  EXPECT_FALSE(turns.is_due(now));
  EXPECT_FALSE(turns.is_due(now + 1h));
}

TEST_F(LocalTurnsTest, AreDueAsLongAsASampleIsBeingPublishedAndUntilItsReadersHaveWokenUp) {
  turns.begin();
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(turns.is_due(now += 10ms));
  turns.end();
  EXPECT_TRUE(turns.is_due(now += 10ms)) << "it is over since";
  EXPECT_TRUE(turns.is_due(now + LocalTurns::time_to_wake - 1ns));
  EXPECT_FALSE(turns.is_due(now + LocalTurns::time_to_wake));
}

TEST_F(LocalTurnsTest, AreDueAfterATurnThatBeganAndEndedUnseen) {
  turns.begin();
  turns.end();
  EXPECT_TRUE(turns.is_due(now));
  EXPECT_FALSE(turns.is_due(now + LocalTurns::time_to_wake));
}

TEST_F(LocalTurnsTest, AreDueUntilTheLastOfSeveralPublishersHasPublished) {
  turns.begin();
  turns.begin();
  turns.end();
  EXPECT_TRUE(turns.is_due(now += 10ms));
  EXPECT_TRUE(turns.is_due(now += 10ms)) << "another one still publishes";
  turns.end();
  EXPECT_TRUE(turns.is_due(now += 10ms));
  EXPECT_FALSE(turns.is_due(now + LocalTurns::time_to_wake));
}

TEST_F(LocalTurnsTest, AreTakenByManyThreadsAndAllEnd) {
  constexpr int threads = 4, turns_each = 10'000;
  {
    std::vector<std::jthread> publishers;
    for (int i = 0; i < threads; ++i) {
      publishers.emplace_back([this] {
        for (int n = 0; n < turns_each; ++n) {
          turns.begin();
          turns.end();
        }
      });
    }
    for (int n = 0; n < turns_each; ++n) turns.is_due(now += 1ns);
  }
  turns.is_due(now);
  EXPECT_FALSE(turns.is_due(now + LocalTurns::time_to_wake));
}

}  // namespace
}  // namespace sft::udp
