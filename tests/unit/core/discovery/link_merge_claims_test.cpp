// Several participants announce one endpoint: these tests check which of them is believed, and what is
// refused.
#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "core/node/tick_pace.h"
#include "tests/unit/core/discovery/link_merge_fixture.h"

namespace sft::core {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST_F(LinkMergeTest, BelievesTheOneThatCameFirstWhileItSpeaks) {
  announces(by_lan, 1);
  announces(stranger, 9, "forged");
  announces(far_stranger, 9, "forged");
  told();
  passes(10s, {by_lan, stranger, far_stranger});
  EXPECT_THAT(told(), ElementsAre(HasSubstr("refused: another participant announces"),
                                  HasSubstr("refused: another participant announces")));
  announces(by_lan, 2);
  EXPECT_THAT(told(), ElementsAre("honest 2 by 11"));
}

TEST_F(LinkMergeTest, RefusesWhatSomebodyElseSaysUnderTheSameRevision) {
  announces(by_lan, 1);
  announces(stranger, 1, "forged");
  passes(4s, {by_lan, stranger});
  EXPECT_THAT(told(), ElementsAre("honest 1 by 11", HasSubstr("refused")));
}

TEST_F(LinkMergeTest, RefusesWithdrawalsByOthers) {
  announces(by_lan, 1);
  told();
  merge.endpoint_withdrawn(stranger, 5, now);
  EXPECT_THAT(told(), ElementsAre(HasSubstr("refused: a participant withdraws an endpoint")));
  announces(stranger, 2, "forged");
  merge.endpoint_withdrawn(stranger, 5, now);
  EXPECT_THAT(told(), IsEmpty()) << "that was its own word";
}

TEST_F(LinkMergeTest, RefusesRequestsByOthers) {
  announces(by_lan, 1);
  asks(stranger, UINT64_MAX);
  passes(2s, {by_lan, stranger});
  asks(by_lan, 2);
  EXPECT_THAT(told(), ElementsAre("honest 1 by 11", HasSubstr("refused: a participant makes requests"),
                                  "request 2 by 11"));
}

TEST_F(LinkMergeTest, RefusesIdsOfAnotherNode) {
  announces(by_lan, 1);
  Endpoint forged = endpoint(2);
  forged.node_id = node + 1;
  merge.endpoint_came(stranger, forged, now);
  EXPECT_THAT(told(), ElementsAre("honest 1 by 11", HasSubstr("refused: another node announces")));
}

/// The node's address has changed: it says farewell to nobody, and has another participant.
TEST_F(LinkMergeTest, BelievesTheEndpointsOwnNodeSoonAlsoIfAnotherNodeAnnouncedTheEndpointFirst) {
  announces_as_another_node(1001);
  announces(by_lan, 1);
  asks(by_lan, 2);
  EXPECT_THAT(told(), ElementsAre("forger 1001 by 13", HasSubstr("refused: another node announces")));
  for (std::uint64_t revision = 1002; revision < 1024; ++revision) {  // the forger goes on, and is heard
    announces_as_another_node(revision);
    passes(100ms, {by_lan});
  }
  std::vector<std::string> after = told();
  std::erase_if(after, [](const std::string& news) { return news.starts_with("forger"); });
  EXPECT_THAT(after, ::testing::IsSupersetOf({"honest 1 by 11", "request 2 by 11"}));
  announces_as_another_node(2000);
  announces(by_lan, 2);
  asks(by_lan, 3);
  passes(5s, {by_lan});
  EXPECT_THAT(told(),
              ElementsAre(HasSubstr("refused: another node announces"), "honest 2 by 11", "request 3 by 11"));
}

TEST_F(LinkMergeTest, BelievesTheEndpointsOwnNodeSoonAlsoIfAnotherParticipantAnnouncedItFirst) {
  announces(stranger, 1001, "forged");
  announces(by_lan, 1);
  for (std::uint64_t revision = 1002; revision < 1030; ++revision) {
    announces(stranger, revision, "forged");
    passes(100ms, {by_lan});
  }
  const std::vector<std::string> after = told();
  ASSERT_FALSE(after.empty());
  EXPECT_EQ(after.back(), "honest 1 by 11");
}

TEST_F(LinkMergeTest, BelievesTheEndpointsOwnNodeAtOnceWhenAnotherNodeThatAnnouncedItFirstGoes) {
  announces_as_another_node(1001);
  announces(by_lan, 1);
  told();
  merge.participant_departed(stranger, now);
  EXPECT_THAT(told(), ElementsAre("honest 1 by 11"));
}

TEST_F(LinkMergeTest, KeepsBelievingANodeThatSaysThatItLivesWhateverAnotherNodeSays) {
  announces(by_lan, 1);
  merge.assertion_came(by_lan, {.node = node, .writers = {}}, now);
  announces_as_another_node(1001);
  told();
  for (int i = 0; i < 50; ++i) {
    merge.assertion_came(stranger, {.node = other_node, .writers = {}}, now);
    passes(100ms);  // its signs of life do not come
  }
  EXPECT_THAT(told(), IsEmpty());
}

TEST_F(LinkMergeTest, BelievesANewParticipantOnceTheOldOneIsSilent) {
  announces(by_lan, 1);
  passes(3s, {by_lan});
  told();
  const Speaker anew{lan, 20};
  announces(anew, 2);
  asks(anew, 7);
  EXPECT_THAT(told(), IsEmpty());
  passes(1700ms, {anew});
  EXPECT_THAT(told(), ElementsAre("honest 2 by 20", "request 7 by 20"));
  announces(anew, 3);
  EXPECT_THAT(told(), ElementsAre("honest 3 by 20"));
}

/// The cable of the first link is cut where nobody sees it.
TEST_F(LinkMergeTest, FollowsTheOtherLinkWhereTheFirstOneFallsSilentAndReturnsToIt) {
  announces(by_lan, 1);
  announces(by_radio, 1);
  passes(3s, {by_lan, by_radio});
  told();
  announces(by_radio, 2);
  asks(by_radio, 5);
  passes(1700ms, {by_radio});
  EXPECT_THAT(told(), ElementsAre("honest 2 by 12, silent on 1", "request 5 by 12"));
  passes(700ms, {by_lan, by_radio});
  EXPECT_THAT(told(), ElementsAre("honest 2 by 12")) << "the first link is heard, but is behind yet";
  announces(by_lan, 2);
  EXPECT_THAT(told(), ElementsAre("honest 2 by 11"));
}

TEST_F(LinkMergeTest, TellsByWhichLinkANodeIsHeardNoMoreAndWhenItIsAgain) {
  announces(by_radio, 1);
  announces(by_lan, 1);
  passes(3s, {by_lan, by_radio});
  told();
  passes(3s, {by_radio});
  EXPECT_THAT(told(), ElementsAre("honest 1 by 12, silent on 1"));
  passes(3s, {by_lan, by_radio});
  EXPECT_THAT(told(), ElementsAre("honest 1 by 12"));
  passes(4s);
  EXPECT_THAT(told(), IsEmpty()) << "all of the node is silent";
}

TEST_F(LinkMergeTest, TellsOfEachSilentLinkOnceAndInOrder) {
  constexpr LinkId far = 3;
  announces({far, 31}, 1);
  announces({far, 32}, 1);
  announces(by_lan, 1);
  announces(by_radio, 1);
  told();
  passes(2s, {by_radio});
  ASSERT_THAT(told(), ElementsAre("honest 1 by 12, silent on 1, silent on 3"));
}

TEST_F(LinkMergeTest, LetsTheFirstOneWithdrawAnEndpointAlsoWhileAnotherIsBelieved) {
  announces(by_lan, 1);
  announces(by_radio, 1);
  passes(3s, {by_radio});
  told();
  merge.endpoint_withdrawn(by_lan, 5, now);
  EXPECT_THAT(told(), ElementsAre("departed"));
}

/// A look that just misses a pulse hears none: until the next one the last pulse is nearly two looks old.
TEST_F(LinkMergeTest, DoesNotTakeASpeakerForSilentWhosePulseWaitsForALook) {
  constexpr auto look_pause = TickPace::pause_in_calm;
  announces(by_lan, 1);
  merge.pulse_came(by_lan, node, now);
  merge.pulses_heard(now);
  told();
  now += look_pause;
  merge.pulses_heard(now);
  now += look_pause - 1ms;
  announces(stranger, 1'000'000, "forged");
  merge.assertion_came(stranger, {.node = node, .writers = {}}, now);
  EXPECT_THAT(told(), IsEmpty());
  now += 1ms;
  merge.pulse_came(by_lan, node, now);
  merge.pulses_heard(now);
  EXPECT_THAT(told(), IsEmpty());
}

TEST_F(LinkMergeTest, TakesASpeakerForSilentOfWhomTwoLooksHaveHeardNoPulse) {
  announces(by_lan, 1);
  announces(by_radio, 1);
  merge.pulse_came(by_lan, node, now);
  told();
  for (int look = 0; look < 2; ++look) {
    EXPECT_THAT(told(), IsEmpty());
    now += TickPace::pause_in_calm;
    merge.pulse_came(by_radio, node, now);
    merge.pulses_heard(now);
    merge.tick(now);
  }
  EXPECT_THAT(told(), ElementsAre("honest 1 by 12, silent on 1"));
}

/// A stranger that used the silence of the honest one is not believed any longer when that one speaks again.
TEST_F(LinkMergeTest, ReturnsToTheFirstOneWhateverWasSaidWhileItWasSilent) {
  announces(by_lan, 1);
  passes(2s);
  announces(stranger, 1'000'000, "forged");
  told();
  passes(2s, {by_lan, stranger});
  EXPECT_THAT(told(), testing::Contains("honest 1 by 11"));
}

}  // namespace
}  // namespace sft::core
