// A link on which records are missing is opened again, with pauses that grow as long as this does not help.
#include "core/discovery/link_care.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

namespace sft::core {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

class LinkCareTest : public ::testing::Test {
 protected:
  LinkCareTest() { care.made(link, now); }

  void misses(std::set<ProcessId> processes) { care.misses({{link, std::move(processes)}}); }
  /// Advances the time by `time`, returns the actions that are due then, and replaces the links that must
  /// be renewed.
  LinkCare::Due after(Time::duration time) {
    now += time;
    const LinkCare::Due due =
        care.look([this](ProcessId process, LinkId) { return helped.contains(process); },
                  [this](LinkId one) { return covered.contains(one); }, now);
    for (const LinkCare::Renewal& renewal : due.renewals) {
      care.made(++link, now);
      care.replaced(renewal.link, link, now);
      misses({renewal.because_of});
      renewed_at.push_back(now);
    }
    return due;
  }
  std::vector<Time::duration> pauses_within(Time::duration time) {
    for (const Time end = now + time; now < end;) after(100ms);
    std::vector<Time::duration> pauses;
    for (std::size_t i = 1; i < renewed_at.size(); ++i) pauses.push_back(renewed_at[i] - renewed_at[i - 1]);
    return pauses;
  }
  bool announces(Time::duration time) { return !after(time).announcements.empty(); }

  const Timing timing;
  Time now = Time(100s);
  LinkId link = 1;
  std::set<ProcessId> helped;
  std::set<LinkId> covered;
  std::vector<Time> renewed_at;
  LinkCare care{0, timing};
};

TEST_F(LinkCareTest, MakesALinkAnewOnWhichSomethingIsMissing) {
  EXPECT_THAT(after(1min).renewals, IsEmpty());
  misses({7});
  const auto renewals = after(0s).renewals;
  ASSERT_EQ(renewals.size(), 1u);
  EXPECT_EQ(renewals[0].link, 1u);
  EXPECT_EQ(renewals[0].because_of, 7u);
  EXPECT_TRUE(care.is_retired(1));
}

TEST_F(LinkCareTest, MakesNoneAnewThatIsNew) {
  misses({7});
  EXPECT_THAT(after(timing.lease - 1ms).renewals, IsEmpty());
  EXPECT_EQ(care.next(), now + 1ms);
  EXPECT_EQ(after(1ms).renewals.size(), 1u);
}

TEST_F(LinkCareTest, WaitsLongerWhileThatDoesNotHelp) {
  misses({7});
  EXPECT_THAT(pauses_within(5min), ElementsAre(timing.lease, 2 * timing.lease, 4 * timing.lease,
                                               8 * timing.lease, 1min, 1min, 1min));
}

TEST_F(LinkCareTest, WaitsNoLongerAgainOnceItHelpsOrTheProcessIsGone) {
  misses({7});
  pauses_within(30s);
  helped = {7};
  after(0s);
  renewed_at.clear();
  misses({8});
  helped.clear();
  pauses_within(6s);
  EXPECT_EQ(renewed_at.size(), 1u);
}

TEST_F(LinkCareTest, HelpsOneProcessBesideAnotherThatIsMadeUp) {
  misses({6, 7});
  helped = {7};
  EXPECT_THAT(pauses_within(30s), ElementsAre(timing.lease, 2 * timing.lease)) << "six is not helped";
}

TEST_F(LinkCareTest, TriesAgainSoonAndThenLaterIfALinkCannotBeMade) {
  misses({7});
  now += timing.lease;
  const auto look = [&] {
    return care.look([](ProcessId, LinkId) { return false; }, [](LinkId) { return false; }, now);
  };
  EXPECT_EQ(look().renewals.size(), 1u);
  EXPECT_THAT(look().renewals, IsEmpty());
  EXPECT_EQ(care.next(), now + timing.try_again);
  now += timing.try_again;
  EXPECT_EQ(look().renewals.size(), 1u);
  EXPECT_EQ(care.next(), now + 2 * timing.try_again);
  for (int i = 0; i < 10; ++i) {
    now = care.next();
    EXPECT_EQ(look().renewals.size(), 1u);
  }
  EXPECT_EQ(care.next(), now + timing.renew_pause_max);
}

TEST_F(LinkCareTest, KeepsAReplacedLinkUntilAllAreHeardOnAnotherOne) {
  care.made(2, now);
  care.replaced(1, 2, now);
  covered = {1};
  EXPECT_THAT(after(timing.retire_after - 1ms).ends, IsEmpty());
  covered = {};
  EXPECT_THAT(after(1s).ends, IsEmpty());
  covered = {1};
  EXPECT_THAT(after(timing.retire_after).ends, ElementsAre(1));
}

TEST_F(LinkCareTest, KeepsAReplacedLinkNoLongerThanALease) {
  care.retire(1, now);
  now += timing.lease - 1ms;
  EXPECT_THAT(after(0ms).ends, IsEmpty());
  EXPECT_THAT(after(timing.retire_after).ends, ElementsAre(1));
  care.gone(1);
  EXPECT_FALSE(care.has(1));
  EXPECT_EQ(care.next(), Time::max());
}

TEST_F(LinkCareTest, LooksNowAndThenWhetherAReplacedLinkMayEnd) {
  care.retire(1, now);
  EXPECT_EQ(care.next(), now + timing.retire_after);
  after(timing.retire_after);
  EXPECT_EQ(care.next(), now + timing.retire_after / 4);
}

TEST_F(LinkCareTest, DoesNotMakeAReplacedLinkAnew) {
  care.retire(1, now);
  misses({7});
  EXPECT_THAT(after(1min).renewals, IsEmpty());
}

TEST_F(LinkCareTest, LetsRecordsOfACrowdTakeTheirTime) {
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

TEST_F(LinkCareTest, AsksEverMoreSeldomWhileTheStrangerStaysOneAndSoonAgainOnceSomebodyJoins) {
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

TEST_F(LinkCareTest, AsksOnAllLinksAfterTheNetworkHasChanged) {
  care.made(2, now);
  care.network_changed(now);
  EXPECT_EQ(after(0s).announcements.size(), 2u);
  EXPECT_TRUE(after(10s).announcements.empty());
}

}  // namespace
}  // namespace sft::core
