// News that are heard on several links are told once, and an endpoint lives while any link has it alive.
#include <gmock/gmock.h>

#include "core/control/control_digest.h"
#include "tests/unit/core/discovery/link_merge_fixture.h"

namespace sft::core {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST_F(LinkMergeTest, TellsOnceWhatComesByTwoLinks) {
  announces(by_lan, 1);
  announces(by_radio, 1);
  asks(by_lan, 2);
  asks(by_radio, 2);
  announces(by_radio, 2);
  announces(by_lan, 2);
  EXPECT_THAT(told(), ElementsAre("honest 1 by 11", "request 2 by 11", "honest 2 by 11"));
  passes(5s, {by_lan, by_radio});
  EXPECT_THAT(told(), IsEmpty());
}

TEST_F(LinkMergeTest, TakesNoOlderAnnouncementBack) {
  announces(by_lan, 3);
  announces(by_lan, 2);
  EXPECT_THAT(told(), ElementsAre("honest 3 by 11"));
}

TEST_F(LinkMergeTest, KeepsAnEndpointWhileAnyLinkHasIt) {
  announces(by_lan, 1);
  announces(by_radio, 1);
  passes(1s, {by_lan, by_radio});
  told();
  merge.endpoint_unheard(lan, 5, now);
  EXPECT_THAT(told(), ElementsAre("honest 1 by 12, silent on 1"));
  passes(1s);
  merge.endpoint_unheard(radio, 5, now);
  passes(10s);
  EXPECT_THAT(told(), ElementsAre("lost", "node lost"));
  announces(by_radio, 1);
  EXPECT_THAT(told(), ElementsAre("honest 1 by 12, silent on 1"));
}

TEST_F(LinkMergeTest, LosesAtOnceWhoWasSilentAndGivesItsLeaseToWhoSpokeAMomentAgo) {
  announces(by_lan, 1);
  passes(2s);
  told();
  merge.participant_departed(by_lan, now);
  EXPECT_THAT(told(), ElementsAre("lost"));
  announces(by_lan, 1);
  told();
  merge.link_dropped(lan, now);  // an address of ours has changed
  passes(4900ms);
  EXPECT_THAT(told(), IsEmpty());
  announces({3, 11}, 1);  // by the new link
  EXPECT_THAT(told(), IsEmpty()) << "nothing has changed";
  passes(10s, {{3, 11}});
  EXPECT_THAT(told(), IsEmpty());
}

TEST_F(LinkMergeTest, LosesAfterItsLeaseWhoDoesNotReturnByAnotherLink) {
  announces(by_lan, 1);
  told();
  merge.link_dropped(lan, now);
  passes(4900ms);
  EXPECT_THAT(told(), IsEmpty());
  passes(200ms);
  EXPECT_THAT(told(), ElementsAre("lost"));
}

TEST_F(LinkMergeTest, LetsNoIdComeBackThatHasDepartedUnlessItIsAnnouncedAnew) {
  announces(by_lan, 4);
  announces(by_radio, 3);
  merge.endpoint_withdrawn(by_lan, 5, now);
  announces(by_radio, 4);
  EXPECT_THAT(told(), ElementsAre("honest 4 by 11", "departed"));
  announces(by_lan, 5);
  EXPECT_THAT(told(), ElementsAre("honest 5 by 11"));
}

TEST_F(LinkMergeTest, TellsOnceOfADepartureByTwoLinks) {
  announces(by_lan, 1);
  announces(by_radio, 1);
  told();
  merge.endpoint_withdrawn(by_radio, 5, now);
  merge.endpoint_withdrawn(by_lan, 5, now);
  EXPECT_THAT(told(), ElementsAre("departed"));
}

TEST_F(LinkMergeTest, PassesOnWhatOthersSayOfOurOwnIds) {
  merge.owns(5);
  announces(stranger, 3, "forged");
  asks(stranger, 9);
  merge.endpoint_withdrawn(stranger, 5, now);
  EXPECT_THAT(told(), ElementsAre("forged 3 by 13", "request 9 by 13", "departed"));
}

TEST_F(LinkMergeTest, TakesForSilenceThreeTenthsOfALeaseWithinBounds) {
  const auto silence_at = [&](std::chrono::milliseconds lease) {
    LinkMerge two_ways;
    Endpoint e = endpoint(1);
    e.life_lease = lease;
    two_ways.endpoint_came(by_lan, e, now);
    two_ways.endpoint_came(by_radio, e, now);
    two_ways.take_news();
    const auto begin = now;
    while (two_ways.take_news().empty() && now < begin + 1min) {
      now += 100ms;
      two_ways.endpoint_came(by_radio, e, now);
      two_ways.tick(now);
    }
    return now - begin - 100ms;
  };
  EXPECT_EQ(silence_at(5s), 1500ms);
  EXPECT_EQ(silence_at(100ms), 300ms);
  EXPECT_EQ(silence_at(1h), 4500ms);
}

TEST_F(LinkMergeTest, WaitsForNobodyLongerThanAMinute) {
  Endpoint e = endpoint(1);
  e.life_lease = 1h;
  merge.endpoint_came(by_lan, e, now);
  merge.link_dropped(lan, now);
  told();
  passes(59s);
  EXPECT_THAT(told(), IsEmpty());
  passes(1s);
  EXPECT_THAT(told(), ElementsAre("lost"));
}

TEST_F(LinkMergeTest, HasADigestOfWhatEachSpeakerHasAnnouncedAndAskedFor) {
  const auto part = [](EndpointId id, std::uint64_t revision, std::uint64_t asked) {
    return digest_part(id, revision, asked);
  };
  announces(by_lan, 1);
  merge.endpoint_came(by_lan, endpoint(4, "honest", 6), now);
  announces(by_radio, 1);
  asks(by_lan, 7);
  EXPECT_EQ(merge.digests()[by_lan], add_to_digest(part(5, 1, 7), part(6, 4, 1)));
  EXPECT_EQ(merge.digests()[by_radio], part(5, 1, 1));
  merge.endpoint_withdrawn(by_lan, 6, now);
  announces(by_lan, 2);
  EXPECT_EQ(merge.digests()[by_lan], part(5, 2, 7));
}

}  // namespace
}  // namespace sft::core
