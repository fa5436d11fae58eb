#include "udp_transport/reliable/attention.h"

#include <gtest/gtest.h>

namespace sft::udp {
namespace {

using namespace std::chrono_literals;

constexpr Attention::Time now{1h};

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
  attention.looks_again_by(now + 10ms);
  EXPECT_EQ(attention.look_by(now + 10ms, now), Wake::none);
  EXPECT_EQ(attention.look_by(now + 9ms, now), Wake::look);
  EXPECT_EQ(attention.look_by(now + 5ms, now), Wake::none) << "the sending thread was woken at `now`";
  attention.looks_again_by(Attention::Time::max());
  EXPECT_EQ(attention.look_by(Attention::Time::max(), now), Wake::none) << "nothing is due";
  EXPECT_EQ(attention.look_by(now + 1h, now), Wake::look);
}

TEST(AttentionTest, WakesNobodyAfterItWasScheduledBecauseTheSendingThreadLooksAtOnce) {
  Attention attention;
  EXPECT_EQ(attention.attract(), Wake::schedule);
  EXPECT_EQ(attention.look_by(now, now), Wake::none);
}

}  // namespace
}  // namespace sft::udp
