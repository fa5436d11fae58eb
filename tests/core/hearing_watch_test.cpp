// A link that does not hear somebody who is there is found out, and one whose people are gone is not.
#include "core/hearing_watch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sft::core {
namespace {

using namespace std::chrono_literals;
using ::testing::IsEmpty;
using Missing = HearingWatch::Missing;

constexpr LinkId lan = 1;
constexpr NodeId node = 77;
constexpr Speaker peer{lan, 11}, other{lan, 12};
constexpr std::uint32_t all = 1234;
constexpr auto lease = 5000ms, participant_lease = 20'000ms;

class HearingWatchTest : public ::testing::Test {
 protected:
  HearingWatchTest() {
    watch.link_made(lan);
    watch.participant_came(peer, true, now);
  }

  /// Time passes in which the peer says that it lives, and what it has announced; nothing if that is 0.
  void passes(std::chrono::milliseconds duration, std::uint32_t said = all) {
    for (const auto end = now + duration; now < end;) {
      now += 500ms;
      if (said != 0) watch.heard_life(peer, node, said, lease, now);
      look();
    }
  }
  void look() {
    deaf.reset();
    for (const auto& one : watch.look(known, participant_lease, now)) deaf = one.missing;
  }

  HearingWatch watch;
  HearingWatch::Now now{1000s};
  std::map<Speaker, std::uint32_t> known{{peer, all}};
  std::optional<Missing> deaf;
};

TEST_F(HearingWatchTest, IsContentAsLongAsSignsOfLifeComeThatSayWhatIsKnown) {
  passes(100s);
  EXPECT_FALSE(deaf);
}

TEST_F(HearingWatchTest, MissesSignsOfLifeThatCycloneSaysCome) {
  passes(3s);
  passes(5s, 0);
  EXPECT_FALSE(deaf) << "all of a lease may get lost";
  passes(1500ms, 0);
  EXPECT_EQ(deaf, Missing::signs_of_life);
}

TEST_F(HearingWatchTest, DoesNotMissANodeOfWhichCycloneSaysThatItIsSilent) {
  passes(3s);
  watch.life_ended(lan, node);
  passes(20s, 0);
  EXPECT_FALSE(deaf) << "it was killed, and its participant is not forgotten yet";
  watch.participant_left(peer);
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
  passes(5s, all + 1);
  EXPECT_FALSE(deaf) << "many may be under way at first";
  passes(10s);
  passes(2500ms, all + 1);
  EXPECT_FALSE(deaf) << "they may be under way";
  passes(1s, all + 1);
  EXPECT_EQ(deaf, Missing::announcements);
}

TEST_F(HearingWatchTest, GivesAnnouncementsTimeAsLongAsTheyCome) {
  for (std::uint32_t i = 0; i < 20; ++i) {
    known[peer] = all + i;
    passes(2s, all + 100);
    EXPECT_FALSE(deaf) << i;
  }
  passes(6s, all + 100);
  EXPECT_EQ(deaf, Missing::announcements);
}

TEST_F(HearingWatchTest, GivesAnnouncementsTimeWhileOtherNodesStart) {
  passes(10s);
  for (AnnouncerId one = 100; one < 110; ++one) {
    watch.participant_came({lan, one}, false, now);
    passes(2s, all + 1);
    EXPECT_FALSE(deaf);
  }
  passes(3s, all + 1);
  EXPECT_EQ(deaf, Missing::announcements);
}

TEST_F(HearingWatchTest, TakesOneSignOfLifeThatAgreesForAnAnswer) {
  passes(10s);
  for (int i = 0; i < 10; ++i) {
    passes(2s, all + 1);
    passes(500ms, all);
    EXPECT_FALSE(deaf) << "somebody else says otherwise in its name";
  }
}

TEST_F(HearingWatchTest, MissesOneWhoIsThereAndSaysNothingAnyMore) {
  passes(3s);
  watch.life_ended(lan, node);  // in its name
  passes(participant_lease, 0);
  EXPECT_FALSE(deaf);
  passes(participant_lease / 2 + 1s, 0);
  EXPECT_EQ(deaf, Missing::everything);
}

TEST_F(HearingWatchTest, TriesThreeTimesForOneOfWhichTheNextLinkHearsNoMore) {
  for (const std::uint32_t said : {all + 1, 0U}) {  // somebody who is made up, or does not get through
    for (int i = 0; i < 3; ++i) {
      passes(participant_lease * 2, said);
      EXPECT_TRUE(deaf) << i;
      watch.tried(peer.participant);
    }
    passes(participant_lease * 2, said);
    EXPECT_FALSE(deaf) << "something else is wrong with it";
    watch.participant_left(peer);
    watch.participant_came(peer, true, now);
  }
}

TEST_F(HearingWatchTest, TriesAgainAndAgainForOneWithWhichAllWasWellOnce) {
  passes(3s);
  for (int i = 0; i < 10; ++i) {
    passes(participant_lease, all + 1);
    EXPECT_TRUE(deaf) << i;
    watch.tried(peer.participant);
  }
}

TEST_F(HearingWatchTest, MissesEndpointsThatGoWithoutTheirParticipant) {
  passes(3s);
  watch.endpoint_unmatched(peer, now);
  watch.life_ended(lan, node);
  passes(1s, 0);
  EXPECT_FALSE(deaf) << "it may be leaving";
  passes(1s, 0);
  EXPECT_EQ(deaf, Missing::endpoints);
  watch.endpoint_matched(peer);
  passes(1s, 0);
  EXPECT_FALSE(deaf);
}

TEST_F(HearingWatchTest, SaysWhenAnotherLinkHearsAllThatTheOneBeforeHears) {
  constexpr LinkId next = 2;
  passes(3s);
  watch.link_made(next);
  watch.link_replaced(lan);
  EXPECT_FALSE(watch.is_replaced_by(lan, next, now));
  watch.participant_came({next, peer.participant}, true, now);
  EXPECT_FALSE(watch.is_replaced_by(lan, next, now));
  watch.heard({next, peer.participant}, now);
  EXPECT_TRUE(watch.is_replaced_by(lan, next, now));
  watch.heard_life(other, node + 1, all, lease, now);
  EXPECT_FALSE(watch.is_replaced_by(lan, next, now));
  now += 3s;
  EXPECT_TRUE(watch.is_replaced_by(lan, next, now)) << "it is not heard any more there, either";
}

TEST_F(HearingWatchTest, ExpectsNothingOfParticipantsThatAreNoNodes) {
  watch.participant_left(peer);
  watch.participant_came(other, false, now);
  passes(100s, 0);
  EXPECT_FALSE(deaf);
}

TEST_F(HearingWatchTest, ForgetsALinkThatIsDropped) {
  passes(3s);
  watch.link_dropped(lan);
  passes(100s, 0);
  watch.heard(peer, now);
  passes(100s, 0);
  EXPECT_FALSE(deaf);
}

}  // namespace
}  // namespace sft::core
