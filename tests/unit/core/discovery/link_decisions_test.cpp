// A link on which records are missing is made anew. The pauses between two attempts grow as long as records
// are missing. A participant whose heartbeats arrive, but which discovery has not found, is asked to
// announce itself.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <utility>
#include <variant>
#include <vector>

#include "core/discovery/peers.h"

namespace sft::core {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class LinkDecisionsTest : public ::testing::Test {
 protected:
  LinkDecisionsTest() {
    peers.listen(Role::writer, now);
    peers.link_made(link, now);
  }

  static constexpr std::uint8_t liar = 7;

  RemoteParticipant on_link(std::uint8_t number) const { return {link, {number}}; }
  void found(std::uint8_t number, bool asks = false) {
    peers.participant_found(on_link(number), number, now, asks);
  }
  /// The participant is found, and gives a heartbeat.
  void joins(std::uint8_t number) {
    found(number);
    heartbeat(number);
  }
  /// The participant gives a heartbeat that counts records which it never writes.
  void heartbeat(std::uint8_t number) { peers.heartbeat_came(link, {{number}, number, {99, 0}}, now); }
  /// The participant writes a record on a new link, and gives a heartbeat that agrees with it.
  void agree(std::uint8_t number) {
    Records records;
    const Record record{1, std::make_shared<const std::vector<std::byte>>(1)};
    records.put({}, record);
    peers.record_came(on_link(number), Role::writer, {}, record, now);
    peers.heartbeat_came(link, {{number}, number, {records.digest(), 0}}, now);
  }

  struct Due {
    std::vector<LinkId> renewals{}, ends{};
    std::vector<bool> announcements{};  ///< true for each one that asks
  };
  /// Advances the time by `time`, returns the actions that are due then, and replaces the links that must
  /// be renewed if that is possible.
  Due after(Time::duration time) {
    Due due;
    now += time;
    peers.look(now);
    for (const PeerAction& action : peers.take_actions()) {
      const auto* const of_link = std::get_if<LinkAction>(&action);
      if (of_link == nullptr) continue;
      using enum LinkAction::Kind;
      if (of_link->kind == renew) due.renewals.push_back(of_link->link);
      if (of_link->kind == end) due.ends.push_back(of_link->link);
      if (of_link->kind == announce || of_link->kind == ask)
        due.announcements.push_back(of_link->kind == ask);
    }
    for (const LinkId renewed : due.renewals) {
      renewed_at.push_back(now);
      if (!can_be_made) continue;
      peers.participant_gone({renewed, {liar}});
      peers.link_made(++link, now);
      peers.link_replaced(renewed, link, now);
      is_new = true;
    }
    for (const LinkId ended : due.ends) peers.link_gone(ended);
    return due;
  }
  /// Returns the times between the renewals while the liar goes on giving heartbeats on each link. If
  /// renewals help, it agrees with the first one on each.
  std::vector<Time::duration> pauses_within(Time::duration time, bool renewals_help = false) {
    renewed_at.clear();
    for (const Time end = now + time; now < end;) {
      found(liar);
      std::exchange(is_new, false) && renewals_help ? agree(liar) : heartbeat(liar);
      for (int i = 0; i < 5; ++i) after(100ms);
    }
    std::vector<Time::duration> pauses;
    for (std::size_t i = 1; i < renewed_at.size(); ++i) pauses.push_back(renewed_at[i] - renewed_at[i - 1]);
    return pauses;
  }
  std::size_t asks_within(int seconds) {
    std::size_t asks = 0;
    for (int second = 0; second < seconds; ++second) {
      heartbeat(9);
      asks += after(1s).announcements.size();
    }
    return asks;
  }
  /// Returns how long after the heartbeats that disagree the participant becomes suspect.
  Time::duration timeout(Peers& of, std::uint8_t number) {
    for (int i = 0; i < 3; ++i) of.heartbeat_came(link, {{number}, number, {99, 0}}, now += 500ms);
    return of.next() - (now - 500ms);
  }

  const Timing timing;
  Time now = Time(100s);
  LinkId link = 1;
  bool is_new = true, can_be_made = true;
  std::vector<Time> renewed_at;
  Peers peers{64, timing};
};

TEST_F(LinkDecisionsTest, WaitLongerWhileRenewalsDoNotHelp) {
  EXPECT_THAT(pauses_within(5min),
              ElementsAre(2 * timing.lease, 4 * timing.lease, 8 * timing.lease, 1min, 1min, 1min));
}

TEST_F(LinkDecisionsTest, WaitNoLongerThanALeaseWhileRenewalsHelp) {
  pauses_within(60s);
  pauses_within(60s, true);
  const auto pauses = pauses_within(60s, true);
  EXPECT_GE(pauses.size(), 8U);
  for (const Time::duration pause : pauses) EXPECT_EQ(pause, timing.lease);
}

TEST_F(LinkDecisionsTest, WaitNoLongerAgainOnceNothingHasBeenMissingForLong) {
  pauses_within(60s);
  peers.participant_gone(on_link(liar));
  after(5min);
  EXPECT_THAT(pauses_within(20s), ElementsAre(2 * timing.lease));
}

TEST_F(LinkDecisionsTest, TryAgainWithTheSamePausesIfALinkCannotBeMade) {
  can_be_made = false;
  EXPECT_THAT(pauses_within(3min), ElementsAre(2 * timing.lease, 4 * timing.lease, 8 * timing.lease, 1min));
}

TEST_F(LinkDecisionsTest, KeepAReplacedLinkForALeaseAndDoNotMakeItAnew) {
  found(liar);
  peers.link_retired(1, now);
  EXPECT_THAT(after(timing.lease - 1ms).ends, IsEmpty());
  for (int i = 0; i < 3; ++i) heartbeat(liar);
  const Due due = after(1ms);
  EXPECT_THAT(due.ends, ElementsAre(1));
  EXPECT_THAT(due.renewals, IsEmpty());
  EXPECT_EQ(peers.next(), Time::max());
}

TEST_F(LinkDecisionsTest, LetRecordsOfManyParticipantsTakeTheirTime) {
  found(liar);
  now += 10s;
  EXPECT_EQ(timeout(peers, liar), 2 * (timing.settle + timing.settle_each)) << "it has never been complete";
  for (std::uint8_t number = 20; number < 30; ++number) joins(number);
  const Time stirred_at = now;
  timeout(peers, liar);
  EXPECT_EQ(peers.next(), stirred_at + 2 * (timing.settle + 11 * timing.settle_each))
      << "the wait begins anew with each newcomer";
}

TEST_F(LinkDecisionsTest, WaitALeaseLongerAtMostForNewcomersThatGoOnComing) {
  found(liar);
  now += 10s;
  const Time since = now + 1s;
  for (int second = 0; second < 12; ++second) {
    found(50);
    heartbeat(liar);
    after(1s);
    peers.participant_gone(on_link(50));
  }
  ASSERT_THAT(renewed_at, SizeIs(1));
  EXPECT_GE(renewed_at[0], since + timing.lease);
}

TEST_F(LinkDecisionsTest, DoNotWaitAsLongInEachProcess) {
  Peers other(32, timing);
  other.listen(Role::writer, now);
  other.link_made(link, now);
  other.participant_found(on_link(liar), liar, now);
  now += 10s;
  EXPECT_EQ(timeout(other, liar), 2 * (timing.settle + timing.settle_each) * 5 / 4);
}

TEST_F(LinkDecisionsTest, AskWhoIsThereIfAStrangerGivesHeartbeats) {
  now += 2 * timing.settle;
  heartbeat(9);
  EXPECT_THAT(after(0s).announcements, ElementsAre(true));
  EXPECT_THAT(after(10s).announcements, IsEmpty());
}

TEST_F(LinkDecisionsTest, DoNotAskWhileOthersAreNew) {
  now += 10s;
  joins(20);
  now += 2 * timing.settle - 1ms;
  heartbeat(9);
  EXPECT_THAT(after(1ms).announcements, IsEmpty());
}

TEST_F(LinkDecisionsTest, AskAfterALeaseAtTheLatestThoughOthersGoOnBeingNew) {
  std::size_t asked = 0;
  for (std::uint8_t second = 0; second < 20; ++second) {
    joins(static_cast<std::uint8_t>(100 + second));
    heartbeat(9);
    asked += after(1s).announcements.size();
  }
  EXPECT_GE(asked, 2U);
  EXPECT_LE(asked, static_cast<std::size_t>(20s / timing.lease));
}

TEST_F(LinkDecisionsTest, AskEverMoreSeldomWhileTheStrangerStaysOneAndSoonAgainOnceAProcessJoins) {
  const std::size_t asked = asks_within(120);
  EXPECT_LE(asked, 25U);
  EXPECT_GE(asked, static_cast<std::size_t>(60s / timing.lease));
  EXPECT_EQ(asks_within(14), 2U);
  joins(20);
  EXPECT_GT(asks_within(14), 2U);
  asks_within(120);
  peers.network_changed(now);
  EXPECT_GT(asks_within(14), 2U) << "another network may have other participants";
}

TEST_F(LinkDecisionsTest, AnswerWhoAsksNoMoreOftenThanHeartbeatsGo) {
  found(20, true);
  EXPECT_THAT(after(10s).announcements, IsEmpty()) << "what a newcomer is said to ask may be old";
  std::size_t answers = 0;
  for (int i = 0; i < 100; ++i) {
    found(20, true);
    heartbeat(20);
    const Due due = after(100ms);
    answers += due.announcements.size();
    for (const bool asks : due.announcements) EXPECT_FALSE(asks);
  }
  EXPECT_LE(answers, 11U);
  EXPECT_GE(answers, 9U);
}

TEST_F(LinkDecisionsTest, RepeatTheAnnouncementWhereHeartbeatsFindNobodyUntilTwoLeasesAreOver) {
  peers.link_made(link, now, false);
  std::vector<Time::duration> announced;
  const Time made_at = now;
  for (int i = 0; i < 300; ++i) {
    const std::vector<bool> announcements = after(100ms).announcements;
    if (!announcements.empty()) announced.push_back(now - made_at);
    for (const bool asks : announcements) EXPECT_FALSE(asks);
  }
  EXPECT_THAT(announced, ElementsAre(1s, 2s, 4s, 8s));
  EXPECT_EQ(peers.next(), Time::max());
}

TEST_F(LinkDecisionsTest, AskOnAllLinksAfterTheNetworkHasChanged) {
  peers.link_made(2, now);
  peers.network_changed(now);
  EXPECT_THAT(after(0s).announcements, ElementsAre(true, true));
  EXPECT_THAT(after(10s).announcements, IsEmpty());
}

}  // namespace
}  // namespace sft::core
