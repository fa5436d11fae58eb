// These tests check which participants count when they say that a node lives, and when the node is lost.
#include "core/discovery/node_claims.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sft::core {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr Speaker by_lan{1, 11}, stranger{1, 13}, by_radio{2, 12};

class NodeClaimsTest : public ::testing::Test {
 protected:
  bool says_that_it_lives(const Speaker& speaker) {
    speakers.heard(speaker, silence, now);
    return claims.asserted(77, speaker, silence, now);
  }
  static std::chrono::milliseconds lease(NodeId) { return 1000ms; }
  std::vector<NodeId> lost() { return claims.take_lost(lease, now); }
  bool is_lost_unheard_on(LinkId link) { return claims.unheard(77, link, lease, now); }

  static constexpr std::chrono::milliseconds silence{300};
  Speakers speakers;
  NodeClaims claims{speakers, 2};
  Time now{1h};
};

TEST_F(NodeClaimsTest, OnEachLinkTheFirstSpeakerCountsUntilItIsSilent) {
  EXPECT_TRUE(says_that_it_lives(by_lan));
  EXPECT_FALSE(says_that_it_lives(stranger));
  EXPECT_TRUE(says_that_it_lives(by_radio));
  EXPECT_TRUE(claims.is_vouched_for(77, by_lan));
  EXPECT_FALSE(claims.is_vouched_for(77, stranger));
  EXPECT_TRUE(claims.is_vouched_for(77, by_radio));
  now += silence + 1ms;
  EXPECT_TRUE(says_that_it_lives(stranger));
}

TEST_F(NodeClaimsTest, ANodeLivesWhileAnyLinkHearsIt) {
  says_that_it_lives(by_lan);
  says_that_it_lives(by_radio);
  now += 10s;
  EXPECT_FALSE(is_lost_unheard_on(1));
  EXPECT_TRUE(is_lost_unheard_on(2));
  EXPECT_FALSE(is_lost_unheard_on(2)) << "it is told once";
  EXPECT_THAT(lost(), IsEmpty());
}

// The nodes of a process have one participant.
TEST_F(NodeClaimsTest, ANodeThatFallsSilentIsLostAlthoughItsSpeakerSpeaksForAnotherNode) {
  says_that_it_lives(by_lan);
  const auto lasts_for = [&](std::chrono::milliseconds time) {
    for (const Time end = now + time; now < end; now += 100ms) {
      speakers.heard(by_lan, silence, now);
      claims.asserted(78, by_lan, silence, now);
      claims.end_silent(lease, now);
      if (!lost().empty()) return false;
    }
    return true;
  };
  EXPECT_TRUE(lasts_for(5s)) << "its signs may have been lost on the way";
  EXPECT_FALSE(lasts_for(10s));
  EXPECT_TRUE(lasts_for(10s)) << "the other node lives";
}

TEST_F(NodeClaimsTest, ANodeThatWasHeardAMomentAgoHasItsLeaseToReturnByAnotherLink) {
  says_that_it_lives(by_lan);
  claims.link_dropped(1);
  EXPECT_THAT(lost(), IsEmpty());
  claims.forget_link(1);
  now += 999ms;
  EXPECT_THAT(lost(), IsEmpty());
  now += 1ms;
  EXPECT_THAT(lost(), ElementsAre(77));
  EXPECT_TRUE(says_that_it_lives(by_radio));
  EXPECT_THAT(lost(), IsEmpty());
}

TEST_F(NodeClaimsTest, ASpeakerThatIsSilentForTooLongDoesNotKeepItsNodeAlive) {
  says_that_it_lives(by_lan);
  now += 20s;
  EXPECT_THAT(lost(), IsEmpty());
  claims.end_silent(lease, now);
  EXPECT_THAT(lost(), ElementsAre(77));
}

TEST_F(NodeClaimsTest, ANodeThatGivesPulsesIsLostAfterItsLease) {
  says_that_it_lives(by_lan);
  speakers.pulse_came(by_lan, now);
  now += 1000ms;
  claims.end_silent(lease, now);
  EXPECT_THAT(lost(), IsEmpty());
  now += 1ms;
  claims.end_silent(lease, now);
  EXPECT_THAT(lost(), ElementsAre(77)) << "Cyclone's lease goes on";
  EXPECT_TRUE(says_that_it_lives(by_lan));
  speakers.pulse_came(stranger, now);
  EXPECT_THAT(lost(), IsEmpty()) << "pulses by speakers that are not known change nothing";
}

TEST_F(NodeClaimsTest, MoreNodesThanThereIsRoomForAreNotTaken) {
  speakers.heard(by_lan, silence, now);
  EXPECT_TRUE(claims.asserted(1, by_lan, silence, now));
  EXPECT_TRUE(claims.asserted(2, by_lan, silence, now));
  EXPECT_FALSE(claims.asserted(3, by_lan, silence, now));
  EXPECT_TRUE(claims.asserted(2, by_lan, silence, now));
}

}  // namespace
}  // namespace sft::core
