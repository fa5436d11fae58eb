// A link on which records are missing is opened again, with pauses that grow as long as this does not help.
#include "core/discovery/link_care.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sft::core {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

class LinkCareTest : public ::testing::Test {
 protected:
  LinkCareTest() { care.made(link, now); }

  /// Records are missing on the link. `help`: renewals of the link have helped before.
  void misses(bool help = false) { care.misses({{link, help}}); }
  /// Advances the time by `time`, returns the actions that are due then, and replaces the links that must
  /// be renewed. The records are missing on the new links, too.
  LinkCare::Due after(Time::duration time, bool help = false) {
    now += time;
    const LinkCare::Due due = care.look(now);
    for (const LinkId renewed : due.renewals) {
      care.made(++link, now);
      care.replaced(renewed, link, now);
      misses(help);
      renewed_at.push_back(now);
    }
    return due;
  }
  std::vector<Time::duration> pauses_within(Time::duration time, bool help = false) {
    for (const Time end = now + time; now < end;) after(100ms, help);
    std::vector<Time::duration> pauses;
    for (std::size_t i = 1; i < renewed_at.size(); ++i) pauses.push_back(renewed_at[i] - renewed_at[i - 1]);
    return pauses;
  }
  bool announces(Time::duration time) { return !after(time).announcements.empty(); }

  const Timing timing;
  Time now = Time(100s);
  LinkId link = 1;
  std::vector<Time> renewed_at;
  LinkCare care{0, timing};
};

TEST_F(LinkCareTest, MakesALinkAnewOnWhichSomethingIsMissing) {
  EXPECT_THAT(after(1min).renewals, IsEmpty());
  misses();
  EXPECT_THAT(after(0s).renewals, ElementsAre(1));
  EXPECT_TRUE(care.is_retired(1));
}

TEST_F(LinkCareTest, MakesNoneAnewThatIsNew) {
  misses();
  EXPECT_THAT(after(timing.lease - 1ms).renewals, IsEmpty());
  EXPECT_EQ(care.next(), now + 1ms);
  EXPECT_EQ(after(1ms).renewals.size(), 1u);
}

TEST_F(LinkCareTest, WaitsLongerWhileThatDoesNotHelp) {
  misses();
  EXPECT_THAT(pauses_within(5min), ElementsAre(timing.lease, 2 * timing.lease, 4 * timing.lease,
                                               8 * timing.lease, 1min, 1min, 1min));
}

TEST_F(LinkCareTest, WaitsNoLongerThanALeaseWhileThatHelps) {
  misses();
  pauses_within(60s);
  renewed_at.clear();
  misses(true);
  for (const Time::duration pause : pauses_within(60s, true)) EXPECT_EQ(pause, timing.lease);
  EXPECT_GE(renewed_at.size(), 9U);
}

TEST_F(LinkCareTest, WaitsNoLongerAgainOnceNothingHasBeenMissingForLong) {
  misses();
  pauses_within(30s);
  care.misses({});
  after(5min);
  renewed_at.clear();
  misses();
  EXPECT_THAT(pauses_within(10s), ElementsAre(timing.lease));
}

TEST_F(LinkCareTest, TriesAgainWithTheSamePausesIfALinkCannotBeMade) {
  misses();
  now += timing.lease;
  EXPECT_THAT(care.look(now).renewals, ElementsAre(1));
  EXPECT_THAT(care.look(now).renewals, IsEmpty());
  EXPECT_EQ(care.next(), now + timing.lease);
  for (int i = 0; i < 10; ++i) {
    now = care.next();
    EXPECT_THAT(care.look(now).renewals, ElementsAre(1));
  }
  EXPECT_EQ(care.next(), now + timing.renew_pause_max);
}

TEST_F(LinkCareTest, KeepsAReplacedLinkForALease) {
  care.retire(1, now);
  EXPECT_EQ(care.next(), now + timing.lease);
  EXPECT_THAT(after(timing.lease - 1ms).ends, IsEmpty());
  EXPECT_THAT(after(1ms).ends, ElementsAre(1));
  care.gone(1);
  EXPECT_FALSE(care.has(1));
  EXPECT_EQ(care.next(), Time::max());
}

TEST_F(LinkCareTest, DoesNotMakeAReplacedLinkAnew) {
  care.retire(1, now);
  misses();
  EXPECT_THAT(after(1min).renewals, IsEmpty());
}

TEST_F(LinkCareTest, LetsRecordsOfManyNewcomersTakeTheirTime) {
  const Time since = now;
  const Time of_none = care.missed_from(link, since, true);
  EXPECT_EQ(of_none, since + timing.settle);
  EXPECT_EQ(care.missed_from(link, since, false), since + 2 * timing.settle) << "it has never been complete";
  for (int i = 0; i < 10; ++i) care.joined(link, now);
  EXPECT_EQ(care.missed_from(link, since, true), since + timing.settle + 10 * timing.settle_each);
  for (int i = 0; i < 1000; ++i) care.joined(link, now);
  EXPECT_EQ(care.missed_from(link, since, true), since + timing.settle + 100 * timing.settle_each);
}

TEST_F(LinkCareTest, BeginsToWaitAnewWithEachNewcomerAndWhatComesOfIt) {
  const Time since = now;
  care.joined(link, now += 3s);
  EXPECT_EQ(care.missed_from(link, since, true), now + timing.settle + timing.settle_each);
  care.stirred(link, now += 1s);
  EXPECT_EQ(care.missed_from(link, since, true), now + timing.settle + timing.settle_each);
}

TEST_F(LinkCareTest, WaitsALeaseLongerAtMostForNewcomersThatGoOnComing) {
  const Time since = now;
  for (int second = 0; second < 20; ++second) {
    care.joined(link, now += 1s);
    care.left(link);
  }
  EXPECT_EQ(care.missed_from(link, since, true), since + timing.lease + timing.settle);
}

TEST_F(LinkCareTest, DoesNotWaitAsLongInEachProcess) {
  EXPECT_EQ(LinkCare(64, timing).next(), Time::max());
  LinkCare other(32, timing);
  other.made(1, now);
  EXPECT_EQ(other.missed_from(1, now, true), now + timing.settle * 5 / 4);
}

TEST_F(LinkCareTest, AsksWhoIsThereIfAStrangerGivesHeartbeats) {
  now += 2 * timing.settle;
  care.unknown_came(link, now);
  const auto asked = after(0s).announcements;
  ASSERT_EQ(asked.size(), 1u);
  EXPECT_TRUE(asked[0].asks);
  EXPECT_FALSE(announces(10s));
}

TEST_F(LinkCareTest, DoesNotAskWhileOthersAreNew) {
  care.joined(link, now);
  now += 2 * timing.settle - 1ms;
  care.unknown_came(link, now);
  EXPECT_FALSE(announces(10s));
}

TEST_F(LinkCareTest, AsksAfterALeaseAtTheLatestThoughOthersGoOnBeingNew) {
  int asked = 0;
  for (int second = 0; second < 20; ++second) {
    care.joined(link, now);
    care.unknown_came(link, now);
    asked += announces(1s) ? 1 : 0;
  }
  EXPECT_GE(asked, 2);
  EXPECT_LE(asked, 20s / timing.lease);
}

TEST_F(LinkCareTest, AsksEverMoreSeldomWhileTheStrangerStaysOneAndSoonAgainOnceAProcessJoins) {
  const auto asks_within = [&](int seconds) {
    int asked = 0;
    for (int second = 0; second < seconds; ++second) {
      care.unknown_came(link, now);
      asked += announces(1s) ? 1 : 0;
    }
    return asked;
  };
  const int asked = asks_within(120);
  EXPECT_LE(asked, 25);
  EXPECT_GE(asked, 60s / timing.lease);
  EXPECT_EQ(asks_within(14), 2);
  care.joined(link, now);
  EXPECT_GT(asks_within(14), 2);
  asks_within(120);
  care.network_changed(now);
  EXPECT_GT(asks_within(14), 2) << "another network may have other participants";
}

TEST_F(LinkCareTest, AnswersWhoAsksNoMoreOftenThanHeartbeatsGo) {
  int answers = 0;
  for (int i = 0; i < 100; ++i) {
    care.was_asked(link);
    const auto announcements = after(100ms).announcements;
    answers += static_cast<int>(announcements.size());
    for (const auto& one : announcements) EXPECT_FALSE(one.asks);
  }
  EXPECT_LE(answers, 11);
  EXPECT_GE(answers, 9);
}

TEST_F(LinkCareTest, AnswersOnceWhoAsksOnce) {
  care.was_asked(link);
  int answers = 0;
  for (int second = 0; second < 60; ++second) answers += announces(1s) ? 1 : 0;
  EXPECT_EQ(answers, 1);
  EXPECT_EQ(care.next(), Time::max());
}

TEST_F(LinkCareTest, RepeatsTheAnnouncementOfALinkOnWhichHeartbeatsFindNobodyUntilTwoLeasesAreOver) {
  care.made(link, now, false);
  std::vector<Time::duration> announced;
  const Time made_at = now;
  for (int i = 0; i < 300; ++i) {
    const auto announcements = after(100ms).announcements;
    if (!announcements.empty()) announced.push_back(now - made_at);
    for (const auto& one : announcements) EXPECT_FALSE(one.asks);
  }
  EXPECT_THAT(announced, ElementsAre(1s, 2s, 4s, 8s));
  EXPECT_EQ(care.next(), Time::max());
}

TEST_F(LinkCareTest, AsksOnAllLinksAfterTheNetworkHasChanged) {
  care.made(2, now);
  care.network_changed(now);
  EXPECT_EQ(after(0s).announcements.size(), 2u);
  EXPECT_TRUE(after(10s).announcements.empty());
}

}  // namespace
}  // namespace sft::core
