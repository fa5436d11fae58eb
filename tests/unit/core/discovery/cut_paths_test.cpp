// Peers report the links on which the path to a process is cut while another link still leads to the
// process.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/core/discovery/peers_fixture.h"

namespace sft::core {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

using CutPathsTest = PeersTest;

TEST_F(CutPathsTest, SaysByWhichLinksTheWayToAProcessIsCut) {
  meet_on_both_links();
  goes_on(timing.late, {wlan});
  EXPECT_THAT(cut_links, ElementsAre(cable));
  goes_on(500ms, {cable, wlan});
  EXPECT_THAT(cut_links, IsEmpty());
}

TEST_F(CutPathsTest, TakesALinkForCutUntilTheProcessIsHeardByItAgain) {
  meet_on_both_links();
  goes_on(2 * timing.lease, {wlan});
  EXPECT_THAT(cut_links, ElementsAre(cable)) << "the participant is silent";
  peers.participant_gone(on(cable));
  goes_on(500ms, {wlan});
  EXPECT_THAT(cut_links, ElementsAre(cable)) << "Cyclone has forgotten the participant";
  found(cable);
  goes_on(500ms, {cable, wlan});
  EXPECT_THAT(cut_links, IsEmpty());
}

TEST_F(CutPathsTest, TakesALinkForCutThatIsCutBeforeTheFirstHeartbeat) {
  found(cable);
  found(wlan);
  goes_on(timing.lease, {wlan});
  EXPECT_THAT(cut_links, ElementsAre(cable));
}

TEST_F(CutPathsTest, TakesTheSuccessorOfALinkThatIsCutForCut) {
  meet_on_both_links();
  goes_on(timing.late, {wlan});
  renew(cable);
  const LinkId successor = last_link;
  peers.link_gone(cable);
  goes_on(500ms, {wlan});
  EXPECT_THAT(cut_links, ElementsAre(successor));
  peers.link_gone(successor);
  goes_on(500ms, {wlan});
  EXPECT_THAT(cut_links, IsEmpty()) << "we have no such link any more";
}

TEST_F(CutPathsTest, TakesNoLinkForCutByWhichAnotherParticipantOfTheProcessIsHeard) {
  meet_on_both_links();
  const RemoteParticipant made_anew = on(cable, 50);
  peers.participant_found(made_anew, neighbour, now);
  for (int i = 0; i < 10; ++i) {
    peers.heartbeat_came(cable, {made_anew.guid, neighbour, {own.digest(), 0}}, now);
    goes_on(500ms, {wlan});
    EXPECT_THAT(cut_links, IsEmpty());
  }
}

TEST_F(CutPathsTest, TakesNoLinkForCutBesideOneByWhichTheProcessWasNeverHeard) {
  found(cable);
  heartbeats({cable});
  found(wlan);
  now += timing.late;
  look();
  EXPECT_THAT(cut_links, IsEmpty());
}

}  // namespace
}  // namespace sft::core
