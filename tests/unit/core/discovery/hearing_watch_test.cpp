// A link that does not hear somebody who is there is found out, and one whose people are gone is not.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "core/node/tick_pace.h"
#include "tests/unit/core/discovery/hearing_watch_fixture.h"

namespace sft::core {
namespace {

using namespace test;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using Missing = HearingWatch::Missing;
using Remedy = HearingWatch::Remedy;

TEST_F(HearingWatchTest, IsContentAsLongAsSignsOfLifeComeThatSayWhatIsKnown) {
  passes(100s);
  EXPECT_FALSE(deaf);
}

TEST_F(HearingWatchTest, KnowsANodeWholeAsLongAsItsSignsOfLifeSaySo) {
  EXPECT_THAT(watch.nodes_known_whole(now), IsEmpty()) << "nothing was heard of it";
  passes(1s);
  EXPECT_THAT(watch.nodes_known_whole(now), ElementsAre(heard_node));
  passes(500ms, all_said + 1);
  EXPECT_THAT(watch.nodes_known_whole(now), IsEmpty()) << "it tells of more";
  passes(500ms);
  EXPECT_THAT(watch.nodes_known_whole(now), ElementsAre(heard_node));
  passes(3s, 0);
  EXPECT_THAT(watch.nodes_known_whole(now), IsEmpty()) << "it is silent";
}

TEST_F(HearingWatchTest, MissesSignsOfLifeThatCycloneSaysCome) {
  passes(3s);
  passes(5s, 0);
  EXPECT_FALSE(deaf) << "all of a lease may get lost";
  passes(1500ms, 0);
  EXPECT_EQ(deaf, Missing::signs_of_life);
}

TEST_F(HearingWatchTest, DoesNotMissANodeThatCycloneReportsAsSilent) {
  passes(3s);
  watch.life_ended(lan, heard_node);
  passes(20s, 0);
  EXPECT_FALSE(deaf) << "it was killed, and its participant is not forgotten yet";
  watch.participant_departed(its_peer);
  passes(100s, 0);
  EXPECT_FALSE(deaf);
}

TEST_F(HearingWatchTest, DoesNotBlameOthersForItsOwnLongPause) {
  passes(3s);
  now += 20s;
  look();
  EXPECT_FALSE(deaf);
  passes(100ms);
  EXPECT_FALSE(deaf);
}

TEST_F(HearingWatchTest, MissesAnnouncementsThatSignsOfLifeTellOfAndThatDoNotCome) {
  passes(5s, all_said + 1);
  EXPECT_FALSE(deaf) << "many may be under way at first";
  passes(10s);
  passes(1s, all_said + 1);
  EXPECT_FALSE(deaf) << "they may be under way";
  passes(500ms, all_said + 1);
  EXPECT_EQ(deaf, Missing::announcements);
}

TEST_F(HearingWatchTest, GivesPeopleTimeToTellMoreOnceItListensToMore) {
  passes(10s);
  watch.hears_more(now);
  passes(5s, all_said + 1);
  EXPECT_FALSE(deaf) << "all that was not listened to before may be under way";
  passes(3s, all_said + 1);
  EXPECT_EQ(deaf, Missing::announcements);
}

TEST_F(HearingWatchTest, NoticesWithTheNextSignOfLifeThatAnAnnouncementWasSomebodyElses) {
  passes(10s);
  is_forged();
  EXPECT_EQ(deaf, Missing::announcements);
}

TEST_F(HearingWatchTest, IsNotMisledByASignOfLifeThatAnAnnouncementHasOvertaken) {
  passes(10s);
  known[its_peer] = all_said + 7;
  look();
  now += 50ms;
  watch.heard_life(its_peer, heard_node, all_said, its_lease, now);
  look();
  EXPECT_FALSE(deaf);
  now += 650ms;
  watch.heard_life(its_peer, heard_node, all_said + 7, its_lease, now);
  look();
  EXPECT_FALSE(deaf);
}

TEST_F(HearingWatchTest, ComplainsFirstAndOftenAndRenewsOnlyWhereThatDoesNotHelp) {
  passes(10s);
  is_forged();
  EXPECT_EQ(remedies, std::vector{Remedy::complaint});
  const auto first = now;
  int complaints = 1;
  while (remedies != std::vector{Remedy::renewal}) {
    now += 100ms;
    look();
    complaints += remedies == std::vector{Remedy::complaint};
    ASSERT_LT(now - first, 2s);
  }
  EXPECT_GT(now - first, 1500ms);
  EXPECT_EQ(complaints, 4);
}

TEST_F(HearingWatchTest, DoesNotBelieveAParticipantAnyMoreWhoseNodeHasComeAnewAfterAComplaint) {
  passes(10s);
  is_forged();
  ASSERT_EQ(remedies, std::vector{Remedy::complaint});
  now += 300ms;
  watch.participant_came(other_peer, now);
  watch.participant_speaks(other_peer, now);
  known[other_peer] = all_said;
  watch.heard(other_peer, now);
  watch.heard_life(other_peer, heard_node, all_said, its_lease, now);
  look();
  EXPECT_EQ(remedies, std::vector{Remedy::disbelief});
  for (int i = 0; i < 20; ++i) {
    now += 500ms;
    watch.heard_life(its_peer, heard_node, all_said, its_lease, now);
    watch.heard_life(other_peer, heard_node, all_said, its_lease, now);
    look();
    EXPECT_THAT(remedies, IsEmpty()) << "it goes soon";
  }
  watch.participant_departed(its_peer);
  passes(2s, 0);
  EXPECT_THAT(remedies, IsEmpty());
}

// The nodes of a process give signs in turns, and the process has a participant on each of its links.
TEST_F(HearingWatchTest, KnowsAProcessByAnyOfItsNodes) {
  constexpr NodeId its_last_node = heard_node + 1;
  passes(10s);
  watch.heard_life(its_peer, its_last_node, all_said, its_lease, now);
  is_forged();
  ASSERT_EQ(remedies, std::vector{Remedy::complaint});
  comes(other_peer);
  now += 100ms;
  look();
  EXPECT_EQ(remedies, std::vector{Remedy::disbelief});
}

// Somebody gives one sign, with one node that is made up, in everybody's name.
TEST_F(HearingWatchTest, TakesNobodyForAnotherBecauseOfANodeThatIsMadeUp) {
  constexpr NodeId made_up = 1, other_node = heard_node + 1;
  passes(10s);
  known[other_peer] = 0;  // it has no endpoints
  for (const NodeId node : {other_node, made_up}) watch.heard_life(other_peer, node, 0, its_lease, now);
  watch.heard_life(its_peer, made_up, 0, its_lease, now);
  while (remedies.empty()) {
    now += 500ms;
    watch.heard_life(other_peer, other_node, 0, its_lease, now);
    look();
  }
  EXPECT_EQ(remedies, std::vector{Remedy::complaint});
}

TEST_F(HearingWatchTest, NobodyWhoComesAfterAComplaintMakesItForgotten) {
  passes(3s);
  known[its_peer] = all_said + 7;

  while (remedies != std::vector{Remedy::complaint}) passes(500ms);
  comes(other_peer);
  now += 100ms;
  look();
  EXPECT_EQ(remedies, std::vector{Remedy::disbelief});
}

TEST_F(HearingWatchTest, WhatIsForgedOnALinkThatIsReplacedIsNotBelievedEither) {
  constexpr LinkId next = 2;
  constexpr Speaker there{next, its_peer.participant};
  passes(10s);
  watch.link_made(next);
  watch.link_replaced(lan, next);
  is_forged();
  EXPECT_THAT(remedies, IsEmpty()) << "the other link has not heard it yet";
  comes(there);
  now += 100ms;
  look();
  EXPECT_EQ(remedies, std::vector{Remedy::disbelief});
}

TEST_F(HearingWatchTest, AParticipantOfAnotherNodeDoesNotCountAsReturned) {
  passes(10s);
  comes(other_peer, heard_node + 1);
  look();
  passes(4s);
  watch.heard_life(other_peer, heard_node + 1, all_said, its_lease, now);
  is_forged();
  now += 10ms;  // of two who may complain
  look();
  EXPECT_EQ(remedies, std::vector{Remedy::complaint});
}

TEST_F(HearingWatchTest, ManyWhoMissTheSameDoNotAllComplainAtOnce) {
  constexpr std::uint64_t nodes = 200;
  std::vector<HearingWatch> watches;
  for (std::uint64_t i = 0; i < nodes; ++i) watches.emplace_back(i);
  std::map<Speaker, std::uint32_t> known_to_all;
  for (AnnouncerId one = 1; one <= nodes; ++one) known_to_all[{lan, one}] = all_said;
  const auto everybody_says = [&](std::uint32_t digest) {
    for (HearingWatch& one : watches) {
      for (AnnouncerId speaker = 1; speaker <= nodes; ++speaker)
        one.heard_life({lan, speaker}, speaker, digest, its_lease, now);
    }
  };
  for (HearingWatch& one : watches) {
    one.link_made(lan);
    for (AnnouncerId speaker = 1; speaker <= nodes; ++speaker) {
      one.participant_came({lan, speaker}, now);
      one.participant_speaks({lan, speaker}, now);
    }
  }
  for (int i = 0; i < 4; ++i) {
    now += 1s;
    everybody_says(all_said);
    for (HearingWatch& one : watches) EXPECT_THAT(one.look(known_to_all, participant_lease, now), IsEmpty());
  }
  known_to_all[{lan, 1}] = all_said + 7;  // forged, and heard by all
  for (HearingWatch& one : watches) (void)one.look(known_to_all, participant_lease, now);
  now += 500ms;
  everybody_says(all_said);
  const auto complaints_now = [&] {
    std::size_t complaints = 0;
    for (HearingWatch& one : watches) complaints += one.look(known_to_all, participant_lease, now).size();
    return complaints;
  };
  EXPECT_LT(complaints_now(), nodes / 10);
  now += 100ms;
  EXPECT_LT(complaints_now(), nodes / 4);
}

TEST_F(HearingWatchTest, LooksMoreOftenWhileSomethingMayBeMissing) {
  passes(10s);
  EXPECT_FALSE(watch.wants_look(now + 900ms));
  EXPECT_TRUE(watch.wants_look(now + TickPace::pause_in_calm));
  EXPECT_EQ(watch.next_look_in_doubt(), Time::max());
  watch.heard(its_peer, now);
  EXPECT_TRUE(watch.wants_look(now + 100ms));
  EXPECT_FALSE(watch.wants_look(now + 90ms));
  EXPECT_EQ(watch.next_look_in_doubt(), now + 100ms);
  look();
  EXPECT_FALSE(watch.wants_look(now + 100ms));
  is_forged();
  EXPECT_TRUE(watch.wants_look(now + 100ms));
}

TEST_F(HearingWatchTest, GivesAnnouncementsTimeAsLongAsTheyCome) {
  for (std::uint32_t i = 0; i < 20; ++i) {
    known[its_peer] = all_said + i;
    passes(2s, all_said + 100);
    EXPECT_FALSE(deaf) << i;
  }
  passes(6s, all_said + 100);
  EXPECT_EQ(deaf, Missing::announcements);
}

TEST_F(HearingWatchTest, GivesAnnouncementsTimeWhileOtherNodesStart) {
  passes(10s);
  for (AnnouncerId one = 100; one < 110; ++one) {
    watch.participant_came({lan, one}, now);
    passes(1s, all_said + 1);
    EXPECT_FALSE(deaf);
  }
  passes(3s, all_said + 1);
  EXPECT_EQ(deaf, Missing::announcements);
}

// Nodes that start in a crowd are told everything at the same time.
TEST_F(HearingWatchTest, GivesNodesOfACrowdMoreTimeUntilTheyHaveAgreedOnce) {
  for (AnnouncerId other = 100; other < 150; ++other) comes({lan, other}, other);
  const auto pass_in_a_crowd = [&](std::chrono::milliseconds duration, std::uint32_t said) {
    for (const auto end = now + duration; now < end;) {
      for (AnnouncerId other = 100; other < 150; ++other)
        watch.heard_life({lan, other}, other, all_said, its_lease, now);
      passes(500ms, said);
    }
  };
  pass_in_a_crowd(7500ms, all_said + 1);
  EXPECT_FALSE(deaf);
  pass_in_a_crowd(2s, all_said + 1);
  EXPECT_EQ(deaf, Missing::announcements);

  pass_in_a_crowd(5s, all_said);
  EXPECT_FALSE(deaf);
  pass_in_a_crowd(1500ms, all_said + 1);
  EXPECT_FALSE(deaf);
  pass_in_a_crowd(2s, all_said + 1);
  EXPECT_EQ(deaf, Missing::announcements);
}

TEST_F(HearingWatchTest, TakesOneSignOfLifeThatAgreesForAnAnswer) {
  passes(10s);
  for (int i = 0; i < 10; ++i) {
    passes(2s, all_said + 1);
    passes(500ms, all_said);
    EXPECT_FALSE(deaf) << "somebody else says otherwise in its name";
  }
}

TEST_F(HearingWatchTest, MissesAParticipantThatIsThereAndSaysNothingAnyMore) {
  passes(3s);
  watch.life_ended(lan, heard_node);  // in its name
  passes(participant_lease * 3 / 2, 0);
  EXPECT_FALSE(deaf);
  passes(1s, 0);
  EXPECT_EQ(deaf, Missing::everything);
}

TEST_F(HearingWatchTest, SoonMissesAParticipantThatHasNeverSaidAnythingUnlessOthersStart) {
  passes(8s, 0);
  EXPECT_FALSE(deaf);
  passes(500ms, 0);
  EXPECT_EQ(deaf, Missing::everything);
  watch.participant_came({lan, 100}, now);
  passes(8s, 0);
  EXPECT_FALSE(deaf) << "it may have much to do";
  passes(500ms, 0);
  EXPECT_EQ(deaf, Missing::everything);
}

TEST_F(HearingWatchTest, MissesSignsOfLifeALittleAfterTheirLeaseAndAnotherLook) {
  passes(3s);
  const auto last = now;
  for (look(); !deaf && now < last + 1min; look()) now += 100ms;
  EXPECT_EQ(deaf, Missing::signs_of_life);
  EXPECT_EQ(now - last, its_lease + 400ms + 400ms);
}

TEST_F(HearingWatchTest, BeginsAnewWithEachSignOfLifeThatIsOverdue) {
  passes(3s);
  for (int i = 0; i < 3; ++i) {
    passes(5500ms, 0);
    EXPECT_FALSE(deaf) << "it is overdue, and comes";
    passes(500ms);
  }
}

TEST_F(HearingWatchTest, DoesNotBlameOthersForAPauseOfItsOwnThatBeginsWhenTheyAreOverdue) {
  passes(3s);
  passes(5500ms, 0);
  now += 2s;
  look();
  EXPECT_FALSE(deaf);
  passes(500ms, 0);
  EXPECT_EQ(deaf, Missing::signs_of_life);
}

TEST_F(HearingWatchTest, NoticesMissingSignsOfLifeAlsoWhenThoseOfOthersEnd) {
  passes(3s);
  watch.life_ended(lan + 1, heard_node);
  watch.life_ended(lan, heard_node + 1);
  passes(6s, 0);
  EXPECT_EQ(deaf, Missing::signs_of_life);
}

TEST_F(HearingWatchTest, DoesNotMissAnnouncementsOfAParticipantThatIsNotHeardAtPresent) {
  passes(10s);
  passes(500ms, all_said + 1);
  for (int i = 0; i < 8; ++i) {
    passes(500ms, 0);
    EXPECT_FALSE(deaf) << "it may have told of them a moment ago";
  }
}

TEST_F(HearingWatchTest, GivesAnnouncementsTimeSinceAllThatIsKnownWasSaidLast) {
  passes(10s);
  passes(2s, 0);
  passes(1s, all_said + 1);
  EXPECT_FALSE(deaf);
  passes(1s, all_said + 1);
  EXPECT_EQ(deaf, Missing::announcements);
}

TEST_F(HearingWatchTest, TakesASignOfLifeThatAgreesForAnAnswerThoughAnotherComesBeforeItLooks) {
  passes(10s);
  for (int i = 0; i < 20; ++i) {
    watch.heard_life(its_peer, heard_node, all_said, its_lease, now);
    passes(500ms, all_said + 1);
    EXPECT_FALSE(deaf) << i;
  }
}

TEST_F(HearingWatchTest, TellsOfOneOnEachLink) {
  const Speaker by_another_link{lan + 1, 13};
  watch.link_made(lan + 1);
  for (const Speaker& one : {its_peer, other_peer, by_another_link}) watch.heard(one, now);
  now += 1min;
  std::vector<LinkId> links;
  for (const auto& one : watch.look({}, participant_lease, now)) links.push_back(one.link);
  EXPECT_EQ(links, (std::vector<LinkId>{lan, lan + 1}));
}

TEST_F(HearingWatchTest, ExpectsNothingOfALinkThatIsReplaced) {
  passes(3s);
  watch.link_made(lan + 1);
  watch.link_replaced(lan, 2);
  for (int i = 0; i < 60; ++i) {
    passes(1s, 0);
    EXPECT_FALSE(deaf);
  }
}

TEST_F(HearingWatchTest, ExpectsSomethingOfSoManySpeakersAndNoMore) {
  watch.link_made(lan + 1);
  for (AnnouncerId one = 100; one < 100 + 4096; ++one) watch.heard({lan, one}, now);
  watch.heard({lan + 1, 99}, now);
  now += 1min;
  const auto missed = watch.look({}, participant_lease, now);
  ASSERT_EQ(missed.size(), 1U);
  EXPECT_EQ(missed.front().link, lan);
}

TEST_F(HearingWatchTest, RenewsALinkAtMostThreeTimesForOneParticipantIfThatDoesNotHelp) {
  for (const std::uint32_t said : {all_said + 1, 0U}) {  // somebody who is made up, or does not get through
    for (int i = 0; i < 3; ++i) {
      passes(participant_lease * 2, said);
      EXPECT_TRUE(deaf) << i;
      watch.tried(its_peer.participant);
    }
    passes(participant_lease * 2, said);
    EXPECT_FALSE(deaf) << "something else is wrong with it";
    watch.participant_departed(its_peer);
    watch.participant_came(its_peer, now);
    watch.participant_speaks(its_peer, now);
  }
}

TEST_F(HearingWatchTest, TriesAgainAndAgainForOneWithWhichAllWasWellOnce) {
  passes(3s);
  for (int i = 0; i < 10; ++i) {
    passes(participant_lease, all_said + 1);
    EXPECT_TRUE(deaf) << i;
    watch.tried(its_peer.participant);
  }
}

TEST_F(HearingWatchTest, MissesEndpointsThatGoWithoutTheirParticipant) {
  watch.endpoint_matched(its_peer, true, now);
  passes(3s);
  watch.endpoint_matched(its_peer, false, now);
  watch.life_ended(lan, heard_node);
  passes(1s, 0);
  EXPECT_FALSE(deaf) << "it may be leaving";
  passes(1s, 0);
  EXPECT_EQ(deaf, Missing::endpoints);
  watch.endpoint_matched(its_peer, true, now);
  passes(1s, 0);
  EXPECT_FALSE(deaf);
}

TEST_F(HearingWatchTest, SaysWhenAnotherLinkHearsAllThatTheOneBeforeHears) {
  constexpr LinkId next = 2;
  passes(3s);
  watch.link_made(next);
  watch.link_replaced(lan, next);
  EXPECT_FALSE(watch.is_replaced_by(lan, next, now));
  watch.participant_came({next, its_peer.participant}, now);
  watch.participant_speaks({next, its_peer.participant}, now);
  EXPECT_FALSE(watch.is_replaced_by(lan, next, now));
  watch.heard({next, its_peer.participant}, now);
  EXPECT_TRUE(watch.is_replaced_by(lan, next, now));
  watch.participant_came(other_peer, now);
  watch.participant_speaks(other_peer, now);
  EXPECT_TRUE(watch.is_replaced_by(lan, next, now)) << "it is not heard on the one before, either";
  watch.heard_life(other_peer, heard_node + 1, all_said, its_lease, now);
  EXPECT_FALSE(watch.is_replaced_by(lan, next, now));
  now += 3s;
  EXPECT_TRUE(watch.is_replaced_by(lan, next, now)) << "it is not heard any more there, either";
}

TEST_F(HearingWatchTest, ExpectsNothingOfParticipantsThatAreNoNodes) {
  watch.participant_departed(its_peer);
  watch.participant_came(other_peer, now);
  passes(100s, 0);
  EXPECT_FALSE(deaf);
}

TEST_F(HearingWatchTest, ForgetsHowOftenItTriedForWhomNoLinkHasAnyMore) {
  passes(participant_lease * 2, 0);
  for (int i = 0; i < 3; ++i) watch.tried(its_peer.participant);
  look();
  EXPECT_FALSE(deaf);
  watch.link_dropped(lan);
  watch.link_made(lan);
  watch.participant_came(its_peer, now);
  watch.participant_speaks(its_peer, now);
  passes(participant_lease, 0);
  EXPECT_EQ(deaf, Missing::everything);
}

TEST_F(HearingWatchTest, ForgetsALinkThatIsDropped) {
  passes(3s);
  watch.link_dropped(lan);
  passes(100s, 0);
  watch.heard(its_peer, now);
  passes(100s, 0);
  EXPECT_FALSE(deaf);
}

}  // namespace
}  // namespace sft::core
