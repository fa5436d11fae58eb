#include "udp_transport/reliable/channel_life.h"

#include <gtest/gtest.h>

#include "tests/unit/udp/start.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;

TEST(ChannelLifeTest, LingersAfterItsLastReaderHasGone) {
  ChannelLife life;
  EXPECT_FALSE(life.has_ended());
  EXPECT_FALSE(life.has_lingered(test_start));
  life.end(test_start);
  EXPECT_TRUE(life.has_ended());
  EXPECT_FALSE(life.is_closed()) << "it repairs yet";
  EXPECT_FALSE(life.has_lingered(test_start + ChannelLife::linger));
  EXPECT_TRUE(life.has_lingered(test_start + ChannelLife::linger + 1ms));
}

TEST(ChannelLifeTest, LingersNoLongerIfItEndsAgain) {
  ChannelLife life;
  life.end(test_start);
  life.end(test_start + 1s);
  EXPECT_TRUE(life.has_lingered(test_start + ChannelLife::linger + 1ms));
}

TEST(ChannelLifeTest, IsLookedAtWhenItHasLingered) {
  ChannelLife life;
  EXPECT_EQ(life.next_look(test_start), test_start);
  EXPECT_EQ(life.next_look(ChannelLife::Time::max()), ChannelLife::Time::max());
  life.end(test_start);
  EXPECT_EQ(life.next_look(test_start + 1s), test_start + 1s) << "something is due before that";
  EXPECT_TRUE(life.has_lingered(life.next_look(ChannelLife::Time::max())));
}

TEST(ChannelLifeTest, EndsWhenItIsClosed) {
  ChannelLife life;
  life.close();
  EXPECT_TRUE(life.is_closed());
  EXPECT_TRUE(life.has_ended());
  EXPECT_FALSE(life.has_lingered(test_start)) << "there is no reader that it would linger for";
}

}  // namespace
}  // namespace sft::udp
