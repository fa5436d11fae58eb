// When a node is lost whose signs of life fail to come, but not all else that it says.
#include "core/node/silence_watch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sft::core {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr NodeId node = 7;
constexpr Time start = Time{} + 100s;

class SilenceWatchTest : public ::testing::Test {
 protected:
  SilenceWatch watch;
};

TEST_F(SilenceWatchTest, ANodeOfWhichNothingElseCameIsLostAtOnce) {
  EXPECT_TRUE(watch.is_lost(node, start));
  watch.heard(node, 5s, start);
  EXPECT_TRUE(watch.is_lost(node, start + 5s));
}

TEST_F(SilenceWatchTest, ANodeOfWhichSomethingCameIsLostALeaseAfterThat) {
  watch.heard(node, 5s, start);
  EXPECT_FALSE(watch.is_lost(node, start + 1s));
  watch.heard(node, 5s, start + 3s);
  EXPECT_THAT(watch.take_lost(start + 8s - 1ms), IsEmpty());
  EXPECT_THAT(watch.take_lost(start + 8s), ElementsAre(node));
  EXPECT_THAT(watch.take_lost(start + 20s), IsEmpty()) << "that was told";
}

TEST_F(SilenceWatchTest, OnceANodeSaysThatItLivesItIsForDiscoveryToTell) {
  watch.heard(node, 5s, start);
  watch.lives(node);
  EXPECT_THAT(watch.take_lost(start + 20s), IsEmpty());
  EXPECT_TRUE(watch.is_lost(node, start + 20s));
}

}  // namespace
}  // namespace sft::core
