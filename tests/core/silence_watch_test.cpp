// When a node is lost whose signs of life fail to come, but not all else that it says.
#include "core/silence_watch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sft::core {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr NodeId node = 7;
constexpr SilenceWatch::Now start = SilenceWatch::Now{} + 100s;

class SilenceWatchTest : public ::testing::Test {
 protected:
  SilenceWatch watch{5s};
};

TEST_F(SilenceWatchTest, ANodeOfWhichNothingElseCameIsLostAtOnce) {
  EXPECT_TRUE(watch.is_lost(node, start));
  watch.heard(node, start, false);
  EXPECT_TRUE(watch.is_lost(node, start + 5s));
  EXPECT_THAT(watch.take_lost(start + 20s), IsEmpty()) << "that was told";
}

TEST_F(SilenceWatchTest, ANodeOfWhichSomethingCameIsLostALeaseAfterThat) {
  watch.heard(node, start, false);
  EXPECT_FALSE(watch.is_lost(node, start + 1s));
  watch.heard(node, start + 3s, false);
  EXPECT_THAT(watch.take_lost(start + 8s - 1ms), IsEmpty());
  EXPECT_THAT(watch.take_lost(start + 8s), ElementsAre(node));
  EXPECT_THAT(watch.take_lost(start + 20s), IsEmpty());
}

TEST_F(SilenceWatchTest, ANodeThatReturnedByWhatItSaidIsLostAgainIfItSaysNoMore) {
  watch.heard(node, start, true);
  EXPECT_THAT(watch.take_lost(start + 5s), ElementsAre(node));
}

TEST_F(SilenceWatchTest, OnceItSaysThatItLivesItIsForDiscoveryToTell) {
  watch.heard(node, start, true);
  watch.lives(node);
  EXPECT_THAT(watch.take_lost(start + 20s), IsEmpty());
}

TEST_F(SilenceWatchTest, ANodeThatIsNotTakenForSilentIsNotLostForSayingNothingElse) {
  watch.heard(node, start, false);
  EXPECT_THAT(watch.take_lost(start + 20s), IsEmpty());
}

}  // namespace
}  // namespace sft::core
