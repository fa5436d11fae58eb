#include "udp_transport/reliable/attention.h"

#include <gtest/gtest.h>

#include "tests/unit/udp/start.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;

TEST(AttentionTest, IsScheduledOnceUntilItRests) {
  Attention attention;
  EXPECT_FALSE(attention.is_paid());
  EXPECT_EQ(attention.attract(), Wake::schedule);
  EXPECT_TRUE(attention.is_paid());
  EXPECT_EQ(attention.attract(), Wake::none) << "the sending thread attends to the channel";
  attention.rest();
  EXPECT_FALSE(attention.is_paid());
  EXPECT_EQ(attention.attract(), Wake::schedule);
}

TEST(AttentionTest, WakesTheSendingThreadOnceBetweenTwoLooks) {
  Attention attention;
  EXPECT_EQ(attention.wake(), Wake::look);
  EXPECT_EQ(attention.wake(), Wake::none) << "the sending thread is about to look";
  attention.looks();
  EXPECT_EQ(attention.wake(), Wake::look);
}

TEST(AttentionTest, WakesTheSendingThreadOnlyForWhatIsDueBeforeItLooks) {
  Attention attention;
  attention.looks_again_by(test_start + 10ms);
  EXPECT_EQ(attention.look_by(test_start + 10ms, test_start), Wake::none);
  EXPECT_EQ(attention.look_by(test_start + 9ms, test_start), Wake::look);
  EXPECT_EQ(attention.look_by(test_start + 5ms, test_start), Wake::none)
      << "the sending thread was woken, and has not looked since";
  attention.looks_again_by(Attention::Time::max());
  EXPECT_EQ(attention.look_by(Attention::Time::max(), test_start), Wake::none) << "nothing is due";
  EXPECT_EQ(attention.look_by(test_start + 1h, test_start), Wake::look);
}

TEST(AttentionTest, WakesNobodyAfterItWasScheduledBecauseTheSendingThreadLooksAtOnce) {
  Attention attention;
  EXPECT_EQ(attention.attract(), Wake::schedule);
  EXPECT_EQ(attention.look_by(test_start, test_start), Wake::none);
}

}  // namespace
}  // namespace sft::udp
