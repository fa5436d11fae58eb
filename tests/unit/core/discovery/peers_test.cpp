// Tests which processes are considered alive, and which of their records are in force.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/core/discovery/peers_fixture.h"

namespace sft::core {
namespace {

using namespace std::chrono_literals;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::Pair;
using ::testing::UnorderedElementsAre;

TEST_F(PeersTest, KnowsWhatAProcessHasOnceItIsFound) {
  writes(0, "a", {cable});
  look();
  EXPECT_EQ(peers.find(neighbour), nullptr);
  found(cable);
  look();
  EXPECT_NE(peers.find(neighbour), nullptr);
  EXPECT_THAT(holds, ElementsAre(Pair(0, "a")));
}

TEST_F(PeersTest, FollowsChangesWithdrawalsAndSlotsThatAreUsedAgain) {
  found(cable);
  writes(0, "a", {cable});
  writes(1, "b", {cable});
  writes(0, "", {cable});
  look();
  EXPECT_THAT(holds, ElementsAre(Pair(1, "b")));
  writes(0, "c", {cable});
  look();
  EXPECT_THAT(holds, ElementsAre(Pair(0, "c"), Pair(1, "b")));
  EXPECT_EQ(peers.find(neighbour)->records[Role::writer].digest(), own.digest());
}

TEST_F(PeersTest, TakesAProcessOnSeveralLinksForOneAndTheNewestRecordForTheRightOne) {
  meet_on_both_links();
  writes(0, "b", {wlan});
  look();
  EXPECT_THAT(holds, ElementsAre(Pair(0, "b"))) << "whichever link has brought it";
  peers.record_came(on(cable), Role::writer, {0, {}}, {revision, body("b")}, now);
  look();
  EXPECT_THAT(holds, ElementsAre(Pair(0, "b")));
}

TEST_F(PeersTest, MissesAProcessOnceNoLinkBringsHeartbeatsForALease) {
  meet_on_both_links();
  goes_on(20s, {wlan});
  EXPECT_EQ(losses, 0);
  now += timing.lease;
  look();
  EXPECT_EQ(losses, 1);
  EXPECT_EQ(peers.find(neighbour), nullptr);
  heartbeats({cable});
  EXPECT_NE(peers.find(neighbour), nullptr);
  EXPECT_THAT(holds, ElementsAre(Pair(0, "a"))) << "its records are still there";
  EXPECT_THAT(renewed, IsEmpty());
}

/// Heartbeats are read once a second, so a heartbeat may be old when it is read.
TEST_F(PeersTest, CountsTheLeaseFromWhenAHeartbeatWasReceivedUnlessThisProcessWasHeldUpMeanwhile) {
  const auto silent_after = [&](Time::duration age) {
    peers.heartbeat_came(cable, {on(cable).guid, neighbour, {own.digest(), 0}}, now, age);
    return peers.next() - now;
  };
  found(cable);
  writes(0, "a", {cable});
  EXPECT_EQ(silent_after(800ms), timing.lease - 800ms);
  EXPECT_EQ(silent_after(20s), timing.lease);
}

TEST_F(PeersTest, MissesAProcessAtOnceWhenAllItsParticipantsAreGone) {
  meet_on_both_links();
  peers.participant_gone(on(cable));
  look();
  EXPECT_EQ(losses, 0);
  peers.participant_gone(on(wlan));
  look();
  EXPECT_EQ(losses, 1);
}

TEST_F(PeersTest, MakesALinkAnewThatDoesNotBringWhatHeartbeatsCount) {
  found(cable);
  writes(0, "a", {cable});
  heartbeats({cable});
  writes(1, "b", {});
  goes_on(4s, {cable});
  EXPECT_THAT(renewed, ElementsAre(cable));
  found(new_cable);
  peers.record_came(on(new_cable), Role::writer, {0, {}}, {1, body("a")}, now);
  peers.record_came(on(new_cable), Role::writer, {1, {}}, {2, body("b")}, now);
  heartbeats({new_cable, cable});
  EXPECT_THAT(holds, ElementsAre(Pair(0, "a"), Pair(1, "b")));
  goes_on(60s, {new_cable});
  EXPECT_THAT(renewed, ElementsAre(cable));
}

TEST_F(PeersTest, SaysFromWhereTheHeartbeatsComeThatCountWhatIsMissing) {
  const IpAddress elsewhere(0x0a000007);
  found(cable);
  std::vector<LinkAction> renewals;
  for (int i = 0; i < 60; ++i) {
    now += 1s;
    peers.heartbeat_came(cable, {on(cable).guid, neighbour, {99, 0}}, now, {}, elsewhere);
    peers.look(now);
    for (const PeerAction& action : peers.take_actions()) {
      const auto* const of_link = std::get_if<LinkAction>(&action);
      if (of_link != nullptr && of_link->kind == LinkAction::Kind::renew) renewals.push_back(*of_link);
    }
  }
  ASSERT_FALSE(renewals.empty());
  EXPECT_EQ(renewals[0].from, elsewhere);
}

/// One later heartbeat on a link that was silent is not enough to make the link anew: that heartbeat may have
/// arrived while a cut link worked for a moment.
TEST_F(PeersTest, MakesNoLinkAnewUnlessAHeartbeatFollowsTheTwoThatDisagree) {
  meet_on_both_links();
  writes(1, "b", {wlan});
  heartbeats({cable, wlan});
  goes_on(500ms, {cable, wlan});
  goes_on(30s, {wlan});
  EXPECT_THAT(renewed, IsEmpty());
  goes_on(10s, {cable, wlan});
  EXPECT_THAT(renewed, ElementsAre(cable));
}

TEST_F(PeersTest, MakesNoLinkAnewWhileRecordsOfAParticipantThatIsBehindGoOnComing) {
  found(cable);
  writes(0, "a", {cable});
  heartbeats({cable});
  for (std::uint32_t slot = 1; slot <= 10; ++slot) writes(slot, "b", {});
  for (std::uint32_t slot = 1; slot <= 10; ++slot) {
    goes_on(500ms, {cable});
    peers.record_came(on(cable), Role::writer, {slot, {}}, {slot + 1, body("b")}, now);
  }
  goes_on(10s, {cable});
  EXPECT_THAT(renewed, IsEmpty());
}

TEST_F(PeersTest, MakesALinkAnewInTimeThoughASilentParticipantGoesOnWriting) {
  found(cable);
  writes(0, "a", {cable});
  const RemoteParticipant silent = on(cable, 99);
  peers.participant_found(silent, neighbour + 1, now);
  goes_on(10s, {cable});
  writes(1, "b", {});
  for (std::uint64_t i = 1; i <= 8; ++i) {
    peers.record_came(silent, Role::writer, {0, {}}, {i, body("a")}, now);
    goes_on(500ms, {cable});
  }
  EXPECT_THAT(renewed, ElementsAre(cable));
}

TEST_F(PeersTest, ForgetsWhatWasForgedOnALinkOnceAnotherOneIsRight) {
  found(cable);
  writes(0, "a", {cable});
  heartbeats({cable});
  forges(cable, 0, "forged");
  forges(cable, 5, "forged");
  look();
  EXPECT_THAT(holds, ElementsAre(Pair(0, "forged"), Pair(5, "forged"))) << "no datagram shows it";
  goes_on(4s, {cable});
  ASSERT_THAT(renewed, ElementsAre(cable));
  found(new_cable);
  peers.record_came(on(new_cable), Role::writer, {0, {}}, {1, body("a")}, now);
  look();
  EXPECT_THAT(holds, ElementsAre(Pair(0, "a")));
}

TEST_F(PeersTest, BelievesTheLinkThatAgreesWithHeartbeatsBesideOneThatDoesNot) {
  meet_on_both_links();
  forges(cable, 0, "forged");
  goes_on(4s, {cable, wlan});
  EXPECT_THAT(holds, ElementsAre(Pair(0, "a")));
  EXPECT_THAT(renewed, ElementsAre(cable));
  writes(0, "b", {wlan});
  look();
  EXPECT_THAT(holds, ElementsAre(Pair(0, "b"))) << "also while heartbeats do not count the change yet";
}

TEST_F(PeersTest, IsNotToldByASingleForgedHeartbeat) {
  meet_on_both_links();
  for (int i = 0; i < 30; ++i) {
    peers.heartbeat_came(cable, {on(cable).guid, neighbour, {12345u + static_cast<unsigned>(i), 0}}, now);
    goes_on(500ms, {cable, wlan});
  }
  EXPECT_THAT(renewed, IsEmpty());
  EXPECT_THAT(holds, ElementsAre(Pair(0, "a")));
}

TEST_F(PeersTest, RefusesAParticipantThatClaimsAProcessWhichLives) {
  found(cable);
  writes(0, "a", {cable});
  heartbeats({cable});
  const auto claims = [&](LinkId link) {
    const RemoteParticipant impostor = on(link, 99);
    peers.participant_found(impostor, neighbour, now);
    peers.record_came(impostor, Role::writer, {0, {}}, {1000, body("claimed")}, now);
    peers.record_came(impostor, Role::writer, {1, {}}, {1001, body("claimed")}, now);
    peers.heartbeat_came(link, {impostor.guid, neighbour, {99, 0}}, now);
  };
  for (int i = 0; i < 80; ++i) {
    claims(renewed.empty() ? wlan : last_link);
    goes_on(500ms, {cable});
    ASSERT_THAT(holds, ElementsAre(Pair(0, "a")));
  }
  writes(0, "b", {cable});
  look();
  EXPECT_THAT(holds, ElementsAre(Pair(0, "b")));
  EXPECT_LE(renewed.size(), 3u) << "in 40 s";
}

TEST_F(PeersTest, RefusesAClaimThatComesBeforeTheFirstHeartbeatOfTheProcess) {
  found(cable);
  writes(0, "a", {cable});
  const RemoteParticipant impostor = on(wlan, 99);
  Records claimed;
  claimed.put({0, {}}, {1000, nullptr});
  peers.participant_found(impostor, neighbour, now);
  peers.record_came(impostor, Role::writer, {0, {}}, {1000, nullptr}, now);
  peers.heartbeat_came(wlan, {impostor.guid, neighbour, {claimed.digest(), 0}}, now);
  look();
  EXPECT_THAT(holds, ElementsAre(Pair(0, "a")));
  goes_on(10s, {cable});
  EXPECT_THAT(holds, ElementsAre(Pair(0, "a")));
}

TEST_F(PeersTest, RefusesAClaimAlsoWhenTheFirstParticipantIsGone) {
  found(cable);
  const RemoteParticipant impostor = on(cable, 99);
  peers.participant_found(impostor, neighbour, now);
  found(wlan);
  writes(0, "a", {cable, wlan});
  heartbeats({cable, wlan});
  peers.participant_gone(on(cable));
  for (int i = 0; i < 20; ++i) {
    peers.heartbeat_came(cable, {impostor.guid, neighbour, {99, 0}}, now);
    goes_on(500ms, {wlan});
    EXPECT_THAT(holds, ElementsAre(Pair(0, "a")));
  }
  EXPECT_THAT(renewed, Not(Contains(wlan))) << "heartbeats of the forged participant do not count";
}

TEST_F(PeersTest, RefusesAClaimOfAProcessThatHasNothingYet) {
  found(cable);
  heartbeats({cable});
  const RemoteParticipant impostor = on(wlan, 99);
  peers.participant_found(impostor, neighbour, now);
  goes_on(2s, {cable});
  peers.record_came(impostor, Role::writer, {0, {}}, {1000, body("claimed")}, now);
  goes_on(2s, {cable});
  EXPECT_THAT(holds, IsEmpty());
}

TEST_F(PeersTest, TakesNoWordAboutItsOwnProcess) {
  peers.participant_found(on(cable), own_process, now);
  peers.record_came(on(cable), Role::writer, {0, {}}, {1, body("a")}, now);
  peers.heartbeat_came(cable, {on(cable).guid, own_process, {}}, now);
  look();
  EXPECT_EQ(peers.find(own_process), nullptr);
  EXPECT_THAT(holds, IsEmpty());
}

TEST_F(PeersTest, TakesNoHeartbeatOfAnotherProcessThanTheParticipants) {
  found(cable);
  heartbeats({cable});
  now += timing.lease;
  peers.heartbeat_came(cable, {on(cable).guid, neighbour + 1, {}}, now);
  look();
  EXPECT_EQ(losses, 1);
}

TEST_F(PeersTest, ComparesWithTheHeartbeatsOfAnotherLinkWhereTheFirstOneIsCut) {
  meet_on_both_links();
  goes_on(3s, {wlan});
  writes(0, "b", {wlan});
  goes_on(timing.lease, {wlan});
  EXPECT_THAT(holds, ElementsAre(Pair(0, "b")));
  EXPECT_THAT(renewed, IsEmpty());
}

TEST_F(PeersTest, SaysOnceThatHeartbeatsDoNotArriveAndHasTimeForThemToComeOtherwise) {
  found(cable);
  writes(0, "a", {cable});
  now += timing.lease - timing.late;
  look();
  EXPECT_THAT(unheard, ElementsAre(cable));
  EXPECT_THAT(holds, ElementsAre(Pair(0, "a")));
  goes_on(30s, {cable});
  EXPECT_THAT(unheard, ElementsAre(cable));
  EXPECT_EQ(losses, 0);
}

TEST_F(PeersTest, MissesAProcessThatEndedBeforeItsFirstHeartbeat) {
  found(cable);
  writes(0, "a", {cable});
  now += timing.lease;
  look();
  EXPECT_EQ(losses, 1);
}

TEST_F(PeersTest, NamesTheTimeOfItsNextLook) {
  EXPECT_EQ(peers.next(), Time::max());
  meet_on_both_links();
  EXPECT_EQ(peers.next(), now + timing.late);
  now += timing.late;
  look();
  EXPECT_EQ(peers.next(), now - timing.late + timing.lease) << "all links are late, and none is cut";
  now = peers.next();
  look();
  EXPECT_EQ(losses, 1);
  EXPECT_EQ(peers.next(), Time::max());
}

class PeerLimitsTest : public PeersTest {
 protected:
  PeerLimitsTest() {
    small.listen(Role::writer, now);
    small.link_made(cable, now);
  }
  /// The participant, each of which belongs to another process, writes a record of that many bytes. Returns
  /// true if there was room for it.
  bool takes(std::uint8_t number, std::uint32_t slot, std::size_t bytes = 1) {
    small.participant_found(on(cable, number), number, now);
    return small.record_came(on(cable, number), Role::writer, {slot, {}},
                             {++revision, body(std::string(bytes, 'x'))}, now);
  }
  std::size_t renewals_within(Time::duration time, std::uint8_t number) {
    std::size_t renewals = 0;
    for (const Time end = now + time; now < end; now += 1s) {
      small.heartbeat_came(cable, {on(cable, number).guid, number, {99, 0}}, now);
      small.look(now);
      for (const PeerAction& action : small.take_actions()) {
        const auto* const of_link = std::get_if<LinkAction>(&action);
        renewals += of_link != nullptr && of_link->kind == LinkAction::Kind::renew ? 1 : 0;
      }
    }
    return renewals;
  }

  Peers small{own_process, timing, {.records = 10, .bytes = 100, .bytes_of_all = 400}};
};

TEST_F(PeerLimitsTest, OneParticipantHasNoMoreRecordsThanItMay) {
  for (std::uint32_t slot = 0; slot < 10; ++slot) EXPECT_TRUE(takes(10, slot));
  EXPECT_FALSE(takes(10, 10));
  EXPECT_TRUE(takes(10, 0)) << "in the place of the one before";
  EXPECT_TRUE(takes(11, 0)) << "another participant has room of its own";
}

TEST_F(PeerLimitsTest, OneParticipantHasNoMoreBytesThanItMay) {
  EXPECT_TRUE(takes(10, 0, 60));
  EXPECT_FALSE(takes(10, 1, 41));
  EXPECT_TRUE(takes(10, 1, 40));
  EXPECT_TRUE(takes(10, 0, 59)) << "in the place of the one before";
  EXPECT_TRUE(takes(11, 0, 100)) << "another participant has room of its own";
}

TEST_F(PeerLimitsTest, AllTogetherHaveNoMoreThanTheyMayAndWhatOneHadIsRoomForOthersOnceItIsGone) {
  for (const std::uint8_t number : {10, 11, 12, 13}) EXPECT_TRUE(takes(number, 0, 100));
  EXPECT_FALSE(takes(14, 0));
  small.participant_gone(on(cable, 10));
  EXPECT_TRUE(takes(14, 0));
}

TEST_F(PeerLimitsTest, ParticipantsThatAreSilentHaveNoRoomWhereItIsCrowded) {
  for (const std::uint8_t number : {10, 11, 12, 13}) EXPECT_TRUE(takes(number, 0, 100));
  now += timing.lease;
  small.look(now);
  EXPECT_TRUE(takes(14, 0, 100));
}

TEST_F(PeerLimitsTest, NoLinkIsMadeAnewForAParticipantWhoseRecordsFindNoRoom) {
  for (std::uint32_t slot = 0; slot <= 10; ++slot) takes(10, slot);
  EXPECT_EQ(renewals_within(60s, 10), 0U);
}

TEST_F(PeerLimitsTest, WhatFoundNoRoomIsFetchedOnceThereIsRoom) {
  for (const std::uint8_t number : {10, 11, 12, 13}) takes(number, 0, 100);
  EXPECT_FALSE(takes(14, 0));
  EXPECT_EQ(renewals_within(4s, 14), 0U);
  for (const std::uint8_t number : {10, 11}) small.participant_gone(on(cable, number));
  EXPECT_GT(renewals_within(10s, 14), 0U);
}

TEST_F(PeersTest, ForgetsRecordsWhoseParticipantIsNotFound) {
  writes(0, "late", {cable});
  now += timing.lease;
  look();
  found(cable);
  look();
  EXPECT_NE(peers.find(neighbour), nullptr);
  EXPECT_THAT(holds, IsEmpty());
}

TEST_F(PeersTest, ForgetsAllOfALinkThatIsGone) {
  meet_on_both_links();
  peers.link_gone(wlan);
  look();
  EXPECT_EQ(losses, 0);
  peers.link_gone(cable);
  look();
  EXPECT_EQ(losses, 1);
  peers.participant_found(on(cable), neighbour, now);
  peers.record_came(on(cable), Role::writer, {0, {}}, {1, body("late")}, now);
  peers.heartbeat_came(cable, {on(cable).guid, neighbour, {}}, now);
  look();
  EXPECT_EQ(peers.find(neighbour), nullptr) << "what comes late of a link that is gone counts for nothing";
}

/// Two participants exchange announcements, and one of these may get lost.
TEST_F(PeersTest, AnnounceThemselvesAgainToAParticipantThatSendsNoHeartbeats) {
  found(cable);
  began_at = now;
  while (now < began_at + 10s) {
    now = std::clamp(peers.next(), now + 1ms, now + 1s);
    look();
  }
  const auto again = [](Time::duration at) { return std::tuple(at, cable, false); };
  EXPECT_THAT(announced, ElementsAre(again(2s), again(3s), again(4s), again(5s), again(6s)));
}

TEST_F(PeersTest, AnnounceThemselvesToNoParticipantAgainThatSendsHeartbeats) {
  found(cable);
  goes_on(10s, {cable});
  EXPECT_THAT(announced, IsEmpty());
}

}  // namespace
}  // namespace sft::core
