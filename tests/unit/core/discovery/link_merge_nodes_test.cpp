// These tests check which signs of life of a node are passed on, and when the node is told to be lost.
#include <gmock/gmock.h>

#include <utility>
#include <vector>

#include "tests/unit/core/discovery/link_merge_fixture.h"

namespace sft::core {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST_F(LinkMergeTest, TellsWhichParticipantGaveASignOfLife) {
  merge.assertion_came(by_radio, {.node = node, .writers = {}}, now);
  const std::vector<News> news = merge.take_news();
  ASSERT_EQ(news.size(), 1U);
  EXPECT_EQ(std::get<Assertion>(news[0]).announcer, by_radio.participant);
}

TEST_F(LinkMergeTest, TakesSignsOfLifeOfTheFirstOneOnEachLink) {
  merge.assertion_came(by_lan, {.node = node, .writers = {}}, now);
  merge.assertion_came(by_radio, {.node = node, .writers = {}}, now);
  EXPECT_EQ(signs_of_life(), 2U);
  merge.assertion_came(stranger, {.node = node, .writers = {}}, now);
  EXPECT_EQ(signs_of_life(), 0U);
  now += 2s;
  merge.assertion_came(stranger, {.node = node, .writers = {}}, now);
  EXPECT_EQ(signs_of_life(), 1U) << "the first one is silent";
}

TEST_F(LinkMergeTest, LosesANodeOnceNoLinkHearsIt) {
  passes(2s, {by_lan, by_radio});
  told();
  now += 5s;
  merge.node_unheard(lan, node, now);
  EXPECT_THAT(told(), IsEmpty());
  merge.node_unheard(radio, node, now);
  EXPECT_THAT(told(), ElementsAre("node lost"));
}

TEST_F(LinkMergeTest, LosesASilentNodeAlsoIfNobodyTellsOfItsEnd) {
  passes(2s, {by_lan});
  told();
  passes(8s);
  EXPECT_THAT(told(), IsEmpty()) << "maybe the link is deaf, and is made anew";
  passes(2s);
  EXPECT_THAT(told(), ElementsAre("node lost"));
}

/// It may be killed before it gives the next one.
TEST_F(LinkMergeTest, LosesANodeAfterItsLeaseWhosePulsesCameBeforeItsFirstSign) {
  merge.pulse_came(by_lan, std::nullopt, now);
  merge.assertion_came(by_lan, {.node = node, .writers = {}}, now);
  told();
  passes(lease_default);
  EXPECT_THAT(told(), IsEmpty());
  passes(100ms);
  EXPECT_THAT(told(), ElementsAre("node lost"));
}

TEST_F(LinkMergeTest, KnowsNoNodeByAPulseThatDoesNotCount) {
  merge.pulse_came(by_lan, std::nullopt, now);
  passes(10s);
  EXPECT_EQ(signs_of_life(), 0U);
  EXPECT_THAT(told(), IsEmpty());
}

TEST_F(LinkMergeTest, LosesANodeAgainThatHadComeBack) {
  passes(2s, {by_lan});
  passes(10s);
  EXPECT_THAT(told(), ElementsAre("node lost"));
  merge.assertion_came(by_lan, {.node = node, .writers = {}}, now);
  merge.node_unheard(lan, node, now);
  EXPECT_THAT(told(), IsEmpty()) << "it has its lease to return";
  passes(5s);
  EXPECT_THAT(told(), ElementsAre("node lost"));
}

TEST_F(LinkMergeTest, LosesASilentNodeAfterItsLeaseOrThatOfMostNodesIfThatIsLonger) {
  for (const auto& [lease, lost_after] : {std::pair{1s, 9s}, {5s, 9s}, {20s, 24s}}) {
    LinkMerge one;
    Endpoint e = endpoint(1);
    e.life_lease = lease;
    one.endpoint_came(by_lan, e, now);
    one.assertion_came(by_lan, {.node = node, .writers = {}}, now);
    one.take_news();
    now += lost_after;
    one.tick(now);
    EXPECT_TRUE(one.take_news().empty()) << lease.count();
    now += 100ms;
    one.tick(now);
    EXPECT_EQ(one.take_news().size(), 1U) << lease.count();
  }
}

TEST_F(LinkMergeTest, KnowsSoManyNodesAndNoMore) {
  LinkMerge small({.endpoints = 2});
  for (NodeId id = 1; id <= 3; ++id) small.assertion_came(by_lan, {.node = id, .writers = {}}, now);
  EXPECT_EQ(small.take_news().size(), 2U);
  small.assertion_came(by_lan, {.node = 1, .writers = {}}, now);
  EXPECT_EQ(small.take_news().size(), 1U);
}

TEST_F(LinkMergeTest, HasRivalsWhileTwoSpeakForOneNodeOrOneEndpoint) {
  EXPECT_FALSE(merge.unrest().has_rivals);
  merge.assertion_came(by_lan, {.node = node, .writers = {}}, now);
  announces(by_lan, 1);
  EXPECT_FALSE(merge.unrest().has_rivals);
  announces(by_radio, 1);
  EXPECT_TRUE(merge.unrest().has_rivals);
  merge.participant_departed(by_radio, now);
  EXPECT_FALSE(merge.unrest().has_rivals);
  merge.assertion_came(by_radio, {.node = node, .writers = {}}, now);
  EXPECT_TRUE(merge.unrest().has_rivals);
  merge.node_unheard(radio, node, now);
  EXPECT_FALSE(merge.unrest().has_rivals);
}

}  // namespace
}  // namespace sft::core
