// News that are heard on several links are told once, and ids are bound to those who announced them first.
#include "core/discovery/link_merge.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "core/control/control_digest.h"

namespace sft::core {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr LinkId lan = 1, radio = 2;
constexpr NodeId node = 77, other_node = 99;
// The honest node has a participant on each link; the other two are somebody else's.
constexpr Speaker by_lan_anew{lan + 7, 11}, by_lan{lan, 11}, by_radio{radio, 12}, stranger{lan, 13},
    far_stranger{radio, 14};

class LinkMergeTest : public ::testing::Test {
 protected:
  static Endpoint endpoint(std::uint64_t revision, const std::string& name = "honest", EndpointId id = 5) {
    Endpoint e;
    e.id = id;
    e.role = Role::reader;
    e.node_id = node;
    e.node = name;
    e.topic = "points";
    e.revision = revision;
    e.request.reader = id;
    e.request.sequence = 1;
    return e;
  }
  static Request request(std::uint64_t sequence, EndpointId reader = 5) {
    Request r;
    r.reader = reader;
    r.sequence = sequence;
    return r;
  }

  void announces(const Speaker& speaker, std::uint64_t revision, const std::string& name = "honest") {
    merge.endpoint_came(speaker, endpoint(revision, name), now);
  }
  void announces_as_another_node(std::uint64_t revision) {
    Endpoint altered = endpoint(revision, "forger");
    altered.node_id = other_node;
    merge.endpoint_came(stranger, altered, now);
  }
  void asks(const Speaker& speaker, std::uint64_t sequence) {
    merge.request_came(speaker, request(sequence), now);
  }
  /// Time passes, in which these say that they live.
  void passes(std::chrono::milliseconds duration, const std::vector<Speaker>& speaking = {}) {
    for (const auto end = now + duration; now < end;) {
      now += 100ms;
      if ((now - start) / 100ms % 6 == 0) {
        for (const Speaker& speaker : speaking)
          merge.assertion_came(speaker, {.node = node, .writers = {}}, now);
      }
      merge.tick(now);
    }
  }

  /// Returns what was told since the last call, without signs of life.
  std::vector<std::string> told() {
    std::vector<std::string> all;
    for (const News& news : merge.take_news()) {
      if (const auto* seen = std::get_if<EndpointSeen>(&news)) {
        all.push_back(seen->endpoint->node + " " + std::to_string(seen->endpoint->revision) + " by " +
                      std::to_string(seen->endpoint->announcer));
        for (const LinkId link : seen->silent) all.back() += ", silent on " + std::to_string(link);
      } else if (const auto* asked = std::get_if<Request>(&news)) {
        all.push_back("request " + std::to_string(asked->sequence) + " by " +
                      std::to_string(asked->announcer));
      } else if (std::holds_alternative<EndpointDeparted>(news)) {
        all.push_back("departed");
      } else if (std::holds_alternative<EndpointLost>(news)) {
        all.push_back("lost");
      } else if (std::holds_alternative<NodeLost>(news)) {
        all.push_back("node lost");
      } else if (const auto* refused = std::get_if<Refused>(&news)) {
        all.push_back("refused: " + refused->why);
      }
    }
    return all;
  }
  std::size_t signs_of_life() {
    std::size_t count = 0;
    for (const News& news : merge.take_news()) count += std::holds_alternative<Assertion>(news) ? 1 : 0;
    return count;
  }

  const Time start{};
  Time now = start + 1h;
  LinkMerge merge;
};

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

TEST_F(LinkMergeTest, TellsOnceOfADepartureByTwoLinks) {
  announces(by_lan, 1);
  announces(by_radio, 1);
  told();
  merge.endpoint_withdrawn(by_radio, 5, now);
  merge.endpoint_withdrawn(by_lan, 5, now);
  EXPECT_THAT(told(), ElementsAre("departed"));
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

/// A stranger that used the silence of the honest one is not believed any longer when that one speaks again.
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

TEST_F(LinkMergeTest, ReturnsToTheFirstOneWhateverWasSaidWhileItWasSilent) {
  announces(by_lan, 1);
  passes(2s);
  announces(stranger, 1'000'000, "forged");
  told();
  passes(2s, {by_lan, stranger});
  EXPECT_THAT(told(), testing::Contains("honest 1 by 11"));
}

TEST_F(LinkMergeTest, PassesOnWhatOthersSayOfOurOwnIds) {
  merge.owns(5);
  announces(stranger, 3, "forged");
  asks(stranger, 9);
  merge.endpoint_withdrawn(stranger, 5, now);
  EXPECT_THAT(told(), ElementsAre("forged 3 by 13", "request 9 by 13", "departed"));
}

TEST_F(LinkMergeTest, KeepsARequestThatComesBeforeItsReader) {
  asks(by_lan, 4);
  asks(stranger, 99);
  announces(by_lan, 1);
  EXPECT_THAT(told(), ElementsAre("honest 1 by 11", "request 4 by 11"));
}

TEST_F(LinkMergeTest, KeepsOfEachOnlyItsLastRequestThatComesBeforeItsReader) {
  for (std::uint64_t sequence = 1; sequence <= 10; ++sequence) asks(by_lan, sequence);
  announces(by_lan, 1);
  EXPECT_THAT(told(), ElementsAre("honest 1 by 11", "request 10 by 11"));
}

TEST_F(LinkMergeTest, KeepsRequestsOfFourThatComeBeforeAReaderAndNoMore) {
  for (AnnouncerId one = 21; one <= 25; ++one) asks({lan, one}, 4);
  asks({lan, 24}, 5);
  announces({lan, 25}, 1);
  EXPECT_THAT(told(), ElementsAre("honest 1 by 25"));
  merge.endpoint_withdrawn({lan, 25}, 5, now);
  announces({lan, 24}, 2);
  EXPECT_THAT(told(), ElementsAre("departed", "honest 2 by 24", "request 5 by 24"));
}

TEST_F(LinkMergeTest, KeepsSoManyRequestsThatComeBeforeTheirReadersAndTheLastOnes) {
  LinkMerge small({.early_requests = 2});
  for (EndpointId id = 5; id <= 7; ++id) small.request_came(by_lan, request(2, id), now);
  for (EndpointId id = 5; id <= 7; ++id) small.endpoint_came(by_lan, endpoint(1, "honest", id), now);
  std::vector<EndpointId> asked;
  for (const News& news : small.take_news()) {
    if (const auto* one = std::get_if<Request>(&news)) asked.push_back(one->reader);
  }
  EXPECT_THAT(asked, ElementsAre(6, 7));
}

TEST_F(LinkMergeTest, ForgetsRequestsWhoseReaderDoesNotCome) {
  asks(by_lan, 4);
  passes(61s);
  announces(by_lan, 1);
  EXPECT_THAT(told(), ElementsAre("honest 1 by 11"));
}

TEST_F(LinkMergeTest, ForgetsRequestsWithTheLinkByWhichTheyCame) {
  asks(by_radio, 4);
  merge.link_dropped(radio, now);
  announces(by_radio, 1);
  EXPECT_THAT(told(), ElementsAre("honest 1 by 12"));
}

TEST_F(LinkMergeTest, TellsNoOlderRequestOfAnotherLinkThanWasToldBefore) {
  announces(by_lan, 1);
  announces(by_radio, 1);
  asks(by_lan, 5);
  passes(3s, {by_radio});
  told();
  asks(by_radio, 4);
  EXPECT_THAT(told(), IsEmpty());
  asks(by_radio, 6);
  EXPECT_THAT(told(), ElementsAre("request 6 by 12"));
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

TEST_F(LinkMergeTest, LosesANodeOfWhichNothingComesAlsoIfNobodyTellsOfItsEnd) {
  passes(2s, {by_lan});
  told();
  passes(8s);
  EXPECT_THAT(told(), IsEmpty()) << "maybe the link is deaf, and is made anew";
  passes(2s);
  EXPECT_THAT(told(), ElementsAre("node lost"));
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

TEST_F(LinkMergeTest, LosesANodeOfWhichNothingComesAfterItsLeaseAndNotBeforeThatOfMost) {
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

TEST_F(LinkMergeTest, GivesEveryParticipantAShareWhateverOneOfThemAnnounces) {
  LinkMerge small({.share = 4, .crowded = 10, .endpoints = 40});
  for (EndpointId id = 1; id <= 100; ++id) small.endpoint_came(stranger, endpoint(1, "flood", id), now);
  small.take_news();
  for (EndpointId id = 1001; id <= 1004; ++id) small.endpoint_came(by_lan, endpoint(1, "honest", id), now);
  for (const News& news : small.take_news()) EXPECT_TRUE(std::holds_alternative<EndpointSeen>(news));
}

TEST_F(LinkMergeTest, TakesNoMoreThanThereIsRoomFor) {
  LinkMerge small({.share = 4, .crowded = 10, .endpoints = 12});
  const auto taken = [&](const Speaker& speaker, EndpointId first) {
    for (EndpointId id = first; id < first + 100; ++id)
      small.endpoint_came(speaker, endpoint(1, "many", id), now);
    const std::vector<News> news = small.take_news();
    return std::ranges::count_if(news, [](const News& n) { return std::holds_alternative<EndpointSeen>(n); });
  };
  EXPECT_EQ(taken(stranger, 1), 10);
  EXPECT_EQ(taken(by_lan, 1001), 2) << "less than its share";
}

TEST_F(LinkMergeTest, HasRoomAgainWhereAnnouncementsGo) {
  LinkMerge small({.share = 2, .crowded = 0, .endpoints = 3});
  const auto comes = [&](const Speaker& speaker, EndpointId id) {
    small.endpoint_came(speaker, endpoint(1, "honest", id), now);
  };
  const auto is_refused = [&] {
    const std::vector<News> news = small.take_news();
    return std::ranges::any_of(news, [](const News& n) { return std::holds_alternative<Refused>(n); });
  };
  comes(by_lan, 5);
  for (EndpointId id = 10; id < 15; ++id) {
    comes(by_lan, id);
    small.endpoint_withdrawn(by_lan, id, now);
    EXPECT_FALSE(is_refused()) << "of that one alone";
  }
  for (int i = 0; i < 5; ++i) {
    comes(stranger, 5);
    small.endpoint_withdrawn(stranger, 5, now);
    EXPECT_FALSE(is_refused()) << "of what another one announces, too";
  }
  for (int i = 0; i < 5; ++i) {
    comes(by_radio, 5);
    small.link_dropped(radio, now);
    EXPECT_FALSE(is_refused()) << "with a link";
  }
  for (int i = 0; i < 5; ++i) {
    comes(by_radio, 5);
    small.participant_departed(by_radio, now);
    now += 61s;
    small.tick(now);
    EXPECT_FALSE(is_refused()) << "long ago";
  }
}

TEST_F(LinkMergeTest, ForgetsWhoIsLostForLong) {
  LinkMerge small({.share = 1, .crowded = 1, .endpoints = 1});
  small.endpoint_came(by_lan, endpoint(1), now);
  now += 2s;
  small.participant_departed(by_lan, now);
  now += 31s;
  small.endpoint_unheard(lan, 5, now);  // it is not, any more
  now += 30s;
  small.tick(now);
  small.take_news();
  small.endpoint_came(by_radio, endpoint(1, "other", 6), now);
  EXPECT_TRUE(std::holds_alternative<EndpointSeen>(small.take_news().at(0))) << "there is room again";
}

}  // namespace
}  // namespace sft::core
