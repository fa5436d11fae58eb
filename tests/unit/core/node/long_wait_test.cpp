// A wait for a callback is reported if it takes long.
#include "core/node/callback_monitor.h"

#include <gtest/gtest.h>

namespace sft::core {
namespace {

using namespace std::chrono_literals;

class LongWaitTest : public ::testing::Test {
 protected:
  const Time begin{};
};

TEST_F(LongWaitTest, AWaitIsReportedOnceWhenItHasBecomeLong) {
  LongWait wait;
  EXPECT_FALSE(wait.look(true, 1, begin));
  EXPECT_FALSE(wait.look(true, 1, begin + 999ms));
  EXPECT_EQ(wait.look(true, 1, begin + 1200ms), 1200ms);
  EXPECT_FALSE(wait.look(true, 1, begin + 5s));
  EXPECT_TRUE(wait.is_under_way());
}

TEST_F(LongWaitTest, AWaitEndsWithATurnOrWhenNothingWaits) {
  LongWait wait;
  EXPECT_FALSE(wait.look(true, 1, begin));
  EXPECT_FALSE(wait.look(true, 2, begin + 900ms)) << "it had a turn, and waits for the next one";
  EXPECT_FALSE(wait.look(true, 2, begin + 1800ms));
  EXPECT_FALSE(wait.look(false, 2, begin + 1850ms));
  EXPECT_FALSE(wait.is_under_way());
  EXPECT_FALSE(wait.look(true, 2, begin + 2800ms));
  EXPECT_TRUE(wait.look(true, 2, begin + 3800ms));
}

TEST_F(LongWaitTest, TheNextLongWaitIsReportedAsWell) {
  LongWait wait;
  EXPECT_FALSE(wait.look(true, 1, begin));
  EXPECT_TRUE(wait.look(true, 1, begin + 1s));
  EXPECT_FALSE(wait.look(true, 2, begin + 2s));
  EXPECT_TRUE(wait.look(true, 2, begin + 3s));
}

}  // namespace
}  // namespace sft::core
