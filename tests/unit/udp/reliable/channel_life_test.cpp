#include "udp_transport/reliable/channel_life.h"

#include <gtest/gtest.h>

namespace sft::udp {
namespace {

using namespace std::chrono_literals;

constexpr ChannelLife::Time now{1h};

TEST(ChannelLifeTest, LingersAfterItsLastReaderHasGone) {
  ChannelLife life;
  EXPECT_FALSE(life.has_ended());
  EXPECT_FALSE(life.has_lingered(now));
  life.end(now);
  EXPECT_TRUE(life.has_ended());
  EXPECT_FALSE(life.is_closed()) << "it repairs yet";
  EXPECT_FALSE(life.has_lingered(now + ChannelLife::linger));
  EXPECT_TRUE(life.has_lingered(now + ChannelLife::linger + 1ms));
}

TEST(ChannelLifeTest, LingersNoLongerIfItEndsAgain) {
  ChannelLife life;
  life.end(now);
  life.end(now + 1s);
  EXPECT_TRUE(life.has_lingered(now + ChannelLife::linger + 1ms));
}

TEST(ChannelLifeTest, IsLookedAtWhenItHasLingered) {
  ChannelLife life;
  EXPECT_EQ(life.next_look(now), now);
  EXPECT_EQ(life.next_look(ChannelLife::Time::max()), ChannelLife::Time::max());
  life.end(now);
  EXPECT_EQ(life.next_look(now + 1s), now + 1s) << "something is due before that";
  EXPECT_TRUE(life.has_lingered(life.next_look(ChannelLife::Time::max())));
}

TEST(ChannelLifeTest, EndsWhenItIsClosed) {
  ChannelLife life;
  life.close();
  EXPECT_TRUE(life.is_closed());
  EXPECT_TRUE(life.has_ended());
  EXPECT_FALSE(life.has_lingered(now)) << "there is no reader that it would linger for";
}

}  // namespace
}  // namespace sft::udp
