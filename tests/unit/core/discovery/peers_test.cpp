// Which processes live, and which of their records hold.
#include "core/discovery/peers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <string>

namespace sft::core {
namespace {

using namespace std::chrono_literals;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Pair;
using ::testing::UnorderedElementsAre;

constexpr LinkId lan = 1, radio = 2, new_lan = 3;
constexpr ProcessId self = 64, other = 7;

/// Another process, with a participant on each link that it is on.
class PeersTest : public ::testing::Test {
 protected:
  PeersTest() {
    peers.listen(Role::writer, now);
    peers.link_made(lan, now);
    peers.link_made(radio, now);
    now += 10s;
  }

  static RemoteParticipant on(LinkId link, std::uint8_t number = 0) {
    return {link, {number == 0 ? static_cast<std::uint8_t>(link) : number}};
  }
  static RecordBody body(const std::string& text) {
    const auto* const first = reinterpret_cast<const std::byte*>(text.data());
    return std::make_shared<const std::vector<std::byte>>(first, first + text.size());
  }
  void found(LinkId link) { peers.participant_found(on(link), other, now); }
  /// The process has a record now, which these links bring.
  void writes(std::uint32_t slot, const std::string& text, const std::vector<LinkId>& by) {
    const Record record{++revision, text.empty() ? nullptr : body(text)};
    own.put({slot, {}}, record);
    for (const LinkId link : by) peers.record_came(on(link), Role::writer, {slot, {}}, record, now);
  }
  /// Somebody writes in the name of the participant on that link.
  void forges(LinkId link, std::uint32_t slot, const std::string& text, std::uint64_t as_revision = 1000) {
    peers.record_came(on(link), Role::writer, {slot, {}}, {as_revision, body(text)}, now);
  }
  void heartbeats(const std::vector<LinkId>& by) {
    for (const LinkId link : by) peers.heartbeat_came(link, {on(link).guid, other, {own.digest(), 0}}, now);
    look();
  }
  /// The process goes on giving heartbeats by these links.
  void goes_on(Time::duration time, const std::vector<LinkId>& by) {
    for (const Time end = now + time; now < end;) {
      now += 500ms;
      heartbeats(by);
    }
  }
  void look() {
    peers.look(now);
    for (const PeerAction& action : peers.take_actions()) {
      if (std::holds_alternative<PeerFound>(action)) ++finds;
      if (std::holds_alternative<PeerLost>(action)) ++losses, holds.clear();
      if (const auto* const record = std::get_if<RecordChanged>(&action)) note(*record);
      if (const auto* const renewal = std::get_if<RenewLink>(&action)) renew(renewal->link);
      if (const auto* const cut = std::get_if<PathsCut>(&action)) cut_links = cut->links;
      if (const auto* const missing = std::get_if<HeartbeatsMissing>(&action))
        unheard.push_back(missing->link);
    }
  }
  void renew(LinkId link) {
    renewed.push_back(link);
    peers.link_made(++last_link, now);
    peers.link_replaced(link, last_link, now);
  }
  void note(const RecordChanged& changed) {
    if (changed.record.is_withdrawn()) {
      holds.erase(changed.key.slot);
      return;
    }
    const auto* const text = reinterpret_cast<const char*>(changed.record.body->data());
    holds[changed.key.slot] = std::string(text, changed.record.body->size());
  }
  /// Both links have brought all that there is.
  void meet_on_both_links() {
    found(lan);
    found(radio);
    writes(0, "a", {lan, radio});
    heartbeats({lan, radio});
    goes_on(10s, {lan, radio});
    ASSERT_THAT(holds, ElementsAre(Pair(0, "a")));
  }

  const Timing timing;
  Time now = Time(100s);
  Peers peers{self, timing};
  Records own;
  LinkId last_link = radio;
  std::uint64_t revision = 0;
  std::map<std::uint32_t, std::string> holds;
  int finds = 0, losses = 0;
  std::vector<LinkId> renewed, cut_links, unheard;
};

TEST_F(PeersTest, KnowsWhatAProcessHasOnceItIsFound) {
  writes(0, "a", {lan});
  look();
  EXPECT_EQ(finds, 0);
  found(lan);
  look();
  EXPECT_EQ(finds, 1);
  EXPECT_THAT(holds, ElementsAre(Pair(0, "a")));
  EXPECT_EQ(peers.newcomer_at(), now);
}

TEST_F(PeersTest, FollowsChangesWithdrawalsAndSlotsThatAreUsedAgain) {
  found(lan);
  writes(0, "a", {lan});
  writes(1, "b", {lan});
  writes(0, "", {lan});
  look();
  EXPECT_THAT(holds, ElementsAre(Pair(1, "b")));
  writes(0, "c", {lan});
  look();
  EXPECT_THAT(holds, ElementsAre(Pair(0, "c"), Pair(1, "b")));
  EXPECT_EQ(peers.find(other)->records(Role::writer).digest(), own.digest());
}

TEST_F(PeersTest, TakesAProcessOnSeveralLinksForOneAndTheNewestRecordForTheRightOne) {
  meet_on_both_links();
  writes(0, "b", {radio});
  look();
  EXPECT_THAT(holds, ElementsAre(Pair(0, "b"))) << "whichever link has brought it";
  peers.record_came(on(lan), Role::writer, {0, {}}, {revision, body("b")}, now);
  look();
  EXPECT_THAT(holds, ElementsAre(Pair(0, "b")));
  EXPECT_EQ(finds, 1);
}

TEST_F(PeersTest, MissesAProcessOnceNoLinkBringsHeartbeatsForALease) {
  meet_on_both_links();
  goes_on(20s, {radio});
  EXPECT_EQ(losses, 0);
  now += timing.lease;
  look();
  EXPECT_EQ(losses, 1);
  EXPECT_EQ(peers.find(other), nullptr);
  heartbeats({lan});
  EXPECT_EQ(finds, 2);
  EXPECT_THAT(holds, ElementsAre(Pair(0, "a"))) << "its records are still there";
  EXPECT_THAT(renewed, IsEmpty());
}

TEST_F(PeersTest, MissesAProcessAtOnceWhenAllItsParticipantsAreGone) {
  meet_on_both_links();
  peers.participant_gone(on(lan));
  look();
  EXPECT_EQ(losses, 0);
  peers.participant_gone(on(radio));
  look();
  EXPECT_EQ(losses, 1);
}

TEST_F(PeersTest, MakesALinkAnewThatDoesNotBringWhatHeartbeatsCount) {
  found(lan);
  writes(0, "a", {lan});
  heartbeats({lan});
  writes(1, "b", {});
  goes_on(4s, {lan});
  EXPECT_THAT(renewed, ElementsAre(lan));
  found(new_lan);
  peers.record_came(on(new_lan), Role::writer, {0, {}}, {1, body("a")}, now);
  peers.record_came(on(new_lan), Role::writer, {1, {}}, {2, body("b")}, now);
  heartbeats({new_lan, lan});
  EXPECT_THAT(holds, ElementsAre(Pair(0, "a"), Pair(1, "b")));
  goes_on(60s, {new_lan});
  EXPECT_THAT(renewed, ElementsAre(lan));
}

TEST_F(PeersTest, ForgetsWhatWasForgedOnALinkOnceAnotherOneIsRight) {
  found(lan);
  writes(0, "a", {lan});
  heartbeats({lan});
  forges(lan, 0, "forged");
  forges(lan, 5, "forged");
  look();
  EXPECT_THAT(holds, ElementsAre(Pair(0, "forged"), Pair(5, "forged"))) << "no datagram shows it";
  goes_on(4s, {lan});
  ASSERT_THAT(renewed, ElementsAre(lan));
  found(new_lan);
  peers.record_came(on(new_lan), Role::writer, {0, {}}, {1, body("a")}, now);
  look();
  EXPECT_THAT(holds, ElementsAre(Pair(0, "a")));
}

TEST_F(PeersTest, BelievesTheLinkThatAgreesWithHeartbeatsBesideOneThatDoesNot) {
  meet_on_both_links();
  forges(lan, 0, "forged");
  goes_on(4s, {lan, radio});
  EXPECT_THAT(holds, ElementsAre(Pair(0, "a")));
  EXPECT_THAT(renewed, ElementsAre(lan));
  writes(0, "b", {radio});
  look();
  EXPECT_THAT(holds, ElementsAre(Pair(0, "b"))) << "also while heartbeats do not count the change yet";
}

TEST_F(PeersTest, IsNotToldByASingleForgedHeartbeat) {
  meet_on_both_links();
  for (int i = 0; i < 30; ++i) {
    peers.heartbeat_came(lan, {on(lan).guid, other, {12345u + static_cast<unsigned>(i), 0}}, now);
    goes_on(500ms, {lan, radio});
  }
  EXPECT_THAT(renewed, IsEmpty());
  EXPECT_THAT(holds, ElementsAre(Pair(0, "a")));
}

TEST_F(PeersTest, RefusesAParticipantThatClaimsAProcessWhichLives) {
  found(lan);
  writes(0, "a", {lan});
  heartbeats({lan});
  const auto claims = [&](LinkId link) {
    const RemoteParticipant claimant = on(link, 99);
    peers.participant_found(claimant, other, now);
    peers.record_came(claimant, Role::writer, {0, {}}, {1000, body("claimed")}, now);
    peers.record_came(claimant, Role::writer, {1, {}}, {1001, body("claimed")}, now);
    peers.heartbeat_came(link, {claimant.guid, other, {99, 0}}, now);
  };
  for (int i = 0; i < 80; ++i) {
    claims(renewed.empty() ? radio : last_link);
    goes_on(500ms, {lan});
    ASSERT_THAT(holds, ElementsAre(Pair(0, "a")));
  }
  writes(0, "b", {lan});
  look();
  EXPECT_THAT(holds, ElementsAre(Pair(0, "b")));
  EXPECT_LE(renewed.size(), 3u) << "in 40 s";
}

TEST_F(PeersTest, RefusesAClaimOfAProcessThatHasNothingYet) {
  found(lan);
  heartbeats({lan});
  const RemoteParticipant claimant = on(radio, 99);
  peers.participant_found(claimant, other, now);
  goes_on(2s, {lan});
  peers.record_came(claimant, Role::writer, {0, {}}, {1000, body("claimed")}, now);
  goes_on(2s, {lan});
  EXPECT_THAT(holds, IsEmpty());
}

TEST_F(PeersTest, TakesNoWordAboutItsOwnProcess) {
  peers.participant_found(on(lan), self, now);
  peers.record_came(on(lan), Role::writer, {0, {}}, {1, body("a")}, now);
  peers.heartbeat_came(lan, {on(lan).guid, self, {}}, now);
  look();
  EXPECT_EQ(finds, 0);
  EXPECT_THAT(holds, IsEmpty());
}

TEST_F(PeersTest, TakesNoHeartbeatOfAnotherProcessThanTheParticipants) {
  found(lan);
  heartbeats({lan});
  now += timing.lease;
  peers.heartbeat_came(lan, {on(lan).guid, other + 1, {}}, now);
  look();
  EXPECT_EQ(losses, 1);
}

TEST_F(PeersTest, SaysByWhichLinksTheWayToAProcessIsCut) {
  meet_on_both_links();
  goes_on(timing.late, {radio});
  EXPECT_THAT(cut_links, ElementsAre(lan));
  goes_on(500ms, {lan, radio});
  EXPECT_THAT(cut_links, IsEmpty());
}

TEST_F(PeersTest, ComparesWithTheHeartbeatsOfAnotherLinkWhereTheFirstOneIsCut) {
  meet_on_both_links();
  goes_on(3s, {radio});
  writes(0, "b", {radio});
  goes_on(timing.lease, {radio});
  EXPECT_THAT(holds, ElementsAre(Pair(0, "b")));
  EXPECT_THAT(renewed, IsEmpty());
}

TEST_F(PeersTest, SaysOnceThatHeartbeatsDoNotArriveAndHasTimeForThemToComeOtherwise) {
  found(lan);
  writes(0, "a", {lan});
  now += timing.lease;
  look();
  EXPECT_THAT(unheard, ElementsAre(lan));
  EXPECT_THAT(holds, ElementsAre(Pair(0, "a")));
  goes_on(30s, {lan});
  EXPECT_THAT(unheard, ElementsAre(lan));
  EXPECT_EQ(losses, 0);
}

TEST_F(PeersTest, MissesAProcessThatEndedBeforeItsFirstHeartbeat) {
  found(lan);
  writes(0, "a", {lan});
  now += 2 * timing.lease;
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

TEST_F(PeersTest, HasRoomForTheRecordsOfOthersWhateverOneParticipantHas) {
  const PeerLimits limits{.records = 10, .bytes = 1000, .crowded = 100, .participants = 2};
  Peers small(self, timing, limits);
  small.listen(Role::writer, now);
  small.link_made(lan, now);
  const auto fill = [&](std::uint8_t number, std::uint32_t records) {
    std::uint32_t room = 0;
    for (std::uint32_t slot = 0; slot < records; ++slot)
      room +=
          small.record_came(on(lan, number), Role::writer, {slot, {}}, {slot + 1, body("a")}, now) ? 1 : 0;
    return room;
  };
  EXPECT_EQ(fill(10, 1000), 100u);
  EXPECT_EQ(fill(11, 1000), 10u);
  EXPECT_TRUE(small.record_came(on(lan, 11), Role::writer, {0, {}}, {9999, body("b")}, now));
  EXPECT_FALSE(small.record_came(on(lan, 12), Role::writer, {0, {}}, {1, body(std::string(1001, 'x'))}, now));
  small.participant_gone(on(lan, 10));
  EXPECT_EQ(fill(13, 1000), 90u);
}

TEST_F(PeersTest, MakesNoLinkAnewForAParticipantWhoseRecordsFindNoRoom) {
  Peers small(self, timing, {.records = 1, .bytes = 1000, .crowded = 1});
  small.listen(Role::writer, now);
  small.link_made(lan, now);
  small.participant_found(on(lan), other, now);
  small.record_came(on(lan), Role::writer, {0, {}}, {1, body("a")}, now);
  EXPECT_FALSE(small.record_came(on(lan), Role::writer, {1, {}}, {2, body("b")}, now));
  for (int i = 0; i < 60; ++i) {
    now += 1s;
    small.heartbeat_came(lan, {on(lan).guid, other, {99, 0}}, now);
    small.look(now);
  }
  for (const PeerAction& action : small.take_actions())
    EXPECT_FALSE(std::holds_alternative<RenewLink>(action));
}

TEST_F(PeersTest, ForgetsAllOfALinkThatIsGone) {
  meet_on_both_links();
  peers.link_gone(radio);
  look();
  EXPECT_EQ(losses, 0);
  peers.link_gone(lan);
  look();
  EXPECT_EQ(losses, 1);
  peers.participant_found(on(lan), other, now);
  peers.record_came(on(lan), Role::writer, {0, {}}, {1, body("late")}, now);
  peers.heartbeat_came(lan, {on(lan).guid, other, {}}, now);
  look();
  EXPECT_EQ(finds, 1) << "what comes late of a link that is gone counts for nothing";
}

}  // namespace
}  // namespace sft::core
