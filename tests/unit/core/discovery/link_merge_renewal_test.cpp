// A link is made anew, or a speaker is disbelieved, because somebody else may have spoken in its name.
#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "tests/unit/core/discovery/link_merge_fixture.h"

namespace sft::core {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST_F(LinkMergeTest, TakesAWithdrawnEndpointBackFromALinkThatIsMadeAnew) {
  announces(by_lan, 3);
  merge.endpoint_withdrawn(by_lan, 5, now);  // in its name
  told();
  merge.begin_anew(by_lan);
  announces(by_lan_anew, 3);
  EXPECT_THAT(told(), ElementsAre("honest 3 by 11"));
}

TEST_F(LinkMergeTest, TakesWhatASpeakerSaysByALinkThatIsMadeAnewForTrueThoughItsNumbersAreLower) {
  announces(by_lan, 3);
  announces(by_lan, 1ULL << 62, "altered");  // in its name
  asks(by_lan, 1ULL << 62);
  told();
  merge.begin_anew(by_lan);
  passes(500ms, {by_lan});
  EXPECT_THAT(told(), IsEmpty()) << "until it is heard there";
  announces(by_lan_anew, 3);
  asks(by_lan_anew, 7);
  passes(500ms, {by_lan, by_lan_anew});
  EXPECT_THAT(told(), ElementsAre("departed", "honest 3 by 11", "request 7 by 11"));
  merge.link_dropped(lan, now);
  passes(5s, {by_lan_anew});
  for (const std::string& news : told()) EXPECT_NE(news, "departed");
  announces(by_lan_anew, 4);
  EXPECT_THAT(told(), ElementsAre("honest 4 by 11"));
}

TEST_F(LinkMergeTest, TakesARequestForUntrueThatAloneWasAltered) {
  announces(by_lan, 3);
  asks(by_lan, 1ULL << 62);  // in its name
  told();
  merge.begin_anew(by_lan);
  announces(by_lan_anew, 3);
  EXPECT_THAT(told(), IsEmpty()) << "a request may be under way";
  passes(600ms, {by_lan, by_lan_anew});
  const std::vector<std::string> news = told();
  ASSERT_GE(news.size(), 2U);
  EXPECT_EQ(news[0], "departed");
  EXPECT_THAT(news[1], HasSubstr("honest 3 by 11"));
}

TEST_F(LinkMergeTest, WhatWasForgedOnALinkThatWasMadeAnewDoesNotOutliveIt) {
  announces(by_lan, 3);
  asks(by_lan, 7);
  announces(by_lan_anew, 3);
  asks(by_lan_anew, 7);
  announces(by_lan, 1ULL << 62, "altered");  // in its name
  asks(by_lan, 1ULL << 62);
  told();
  merge.replaced_link_dropped(lan, now);
  passes(100ms, {by_lan_anew});
  EXPECT_THAT(told(), ElementsAre("departed", "honest 3 by 11", "request 7 by 11"));
}

TEST_F(LinkMergeTest, BelievesAtOnceWhoComesAnewInPlaceOfADisbelievedSpeaker) {
  announces(by_lan, 3);
  announces(by_lan, 1ULL << 62, "altered");  // in its name
  asks(by_lan, 1ULL << 62);
  told();
  announces(stranger, 3);  // here its node's own, which has made its link anew
  asks(stranger, 7);
  passes(200ms, {by_lan, stranger});
  EXPECT_THAT(told(), IsEmpty());
  merge.disbelieve(by_lan, now);
  EXPECT_THAT(told(), ElementsAre("departed", "honest 3 by 13", "request 7 by 13"));
}

TEST_F(LinkMergeTest, DoesNotReturnToADisbelievedSpeakerAsLongAsItGoesOnToSpeakForItsNode) {
  announces(by_lan, 3);
  passes(2s, {by_lan});
  asks(by_lan, 1ULL << 62);  // in its name
  announces(stranger, 3);    // here its node's own
  asks(stranger, 7);
  merge.disbelieve(by_lan, now);
  told();
  passes(10s, {by_lan, stranger});
  EXPECT_THAT(told(), IsEmpty());
  merge.participant_departed(by_lan, now);
  passes(10s, {stranger});
  EXPECT_THAT(told(), IsEmpty());
}

// A deaf link did not hear the withdrawal. Then the node made its link anew, and does not speak of it any
// more.
TEST_F(LinkMergeTest, EndsALostEndpointOnceAllThatItsLivingNodeAnnouncesIsKnown) {
  announces(by_lan, 3);
  told();
  merge.participant_departed(by_lan, now);
  merge.end_what_was_lost_of({node});
  EXPECT_THAT(told(), IsEmpty()) << "it may return until it is lost";
  passes(6s, {stranger});  // here its node's own
  EXPECT_THAT(told(), ElementsAre("lost"));
  merge.end_what_was_lost_of({other_node});
  EXPECT_THAT(told(), IsEmpty());
  merge.end_what_was_lost_of({node});
  EXPECT_THAT(told(), ElementsAre("departed"));
  announces(stranger, 3);
  EXPECT_THAT(told(), ElementsAre("honest 3 by 13")) << "nobody has withdrawn it";
}

TEST_F(LinkMergeTest, DoesNotTakeBackWhatANewLinkSaysOnceMore) {
  announces(by_lan, 3);
  asks(by_lan, 7);
  told();
  merge.begin_anew(by_lan);
  announces(by_lan_anew, 3);
  asks(by_lan_anew, 7);
  merge.link_dropped(lan, now);
  for (const std::string& news : told()) EXPECT_NE(news, "departed");
}

}  // namespace
}  // namespace sft::core
