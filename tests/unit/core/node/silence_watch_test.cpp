// When a node is lost whose signs of life fail to come, but not all else that it says.
#include "core/node/silence_watch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/core/start.h"

namespace sft::core {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr NodeId silent_node = 7;

class SilenceWatchTest : public ::testing::Test {
 protected:
  SilenceWatch watch;
};

TEST_F(SilenceWatchTest, ANodeThatSentNothingElseIsLostAtOnce) {
  EXPECT_TRUE(watch.is_lost(silent_node, test_start));
  watch.lives(silent_node);
  watch.heard(silent_node, 5s, test_start);
  EXPECT_TRUE(watch.is_lost(silent_node, test_start + 5s));
}

TEST_F(SilenceWatchTest, ANodeThatSentSomethingIsLostALeaseAfterThat) {
  watch.lives(silent_node);
  watch.heard(silent_node, 5s, test_start);
  EXPECT_FALSE(watch.is_lost(silent_node, test_start + 1s));
  watch.heard(silent_node, 5s, test_start + 3s);
  EXPECT_THAT(watch.take_lost(test_start + 8s - 1ms), IsEmpty());
  EXPECT_THAT(watch.take_lost(test_start + 8s), ElementsAre(silent_node));
  EXPECT_THAT(watch.take_lost(test_start + 20s), IsEmpty()) << "that was told";
}

TEST_F(SilenceWatchTest, OnceANodeSaysThatItLivesItIsForDiscoveryToTell) {
  watch.heard(silent_node, 5s, test_start);
  watch.lives(silent_node);
  EXPECT_THAT(watch.take_lost(test_start + 20s), IsEmpty());
  watch.heard(silent_node, 5s, test_start + 20s);
  EXPECT_THAT(watch.take_lost(test_start + 40s), IsEmpty()) << "whatever else it says";
  EXPECT_TRUE(watch.is_lost(silent_node, test_start + 40s));
}

TEST_F(SilenceWatchTest, ANodeThatWasNeverHeardToLiveIsLostALeaseAfterItSaidSomething) {
  watch.heard(silent_node, 5s, test_start);
  EXPECT_THAT(watch.take_lost(test_start + 5s - 1ms), IsEmpty());
  EXPECT_THAT(watch.take_lost(test_start + 5s), ElementsAre(silent_node));
}

}  // namespace
}  // namespace sft::core
