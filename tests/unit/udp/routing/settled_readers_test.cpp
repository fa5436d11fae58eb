// These tests check when readers are put into multicast groups: soon after they appear, or after their
// requests have not changed for some time.
#include "tests/support/parse_datagram.h"
#include "tests/unit/udp/routing/group_keeper_fixture.h"

namespace sft::udp::test {
namespace {

TEST_F(GroupKeeperTest, GathersThoseThatAskForTheSameAHundredthOfASecondAfterTheyCame) {
  readers(3);
  serve();
  EXPECT_EQ(why(1), unsettled);
  EXPECT_EQ(time_until_plan(), 10ms);
  ASSERT_EQ(groups_.size(), 1U);
  EXPECT_EQ(groups_[0]->members().size(), 3U);
  ASSERT_EQ(merged_.size(), 1U);
  EXPECT_EQ(merged_[0].destinations.size(), 3U);
  EXPECT_EQ(merged_[0].readers.size(), 3U);
  EXPECT_EQ(merged_[0].reliable.size(), 3U);
  EXPECT_TRUE(why(2).starts_with("group 239.255.")) << why(2);
  EXPECT_TRUE(why(2).ends_with(" of 3; it has not reported any sample of the group yet, or no more"));
}

TEST_F(GroupKeeperTest, GathersSettledReadersWithTheFirstSample) {
  readers(3);
  serve();
  now_ += 10s;
  EXPECT_FALSE(keeper_->replan(now_));
  EXPECT_EQ(go_on(1ms), 1);
  EXPECT_EQ(members(), 3U);
}

TEST_F(GroupKeeperTest, TakesInWhoComesLaterAHundredthOfASecondAfterItCame) {
  readers(2);
  serve();
  go_on(200ms);
  ASSERT_EQ(members(), 2U);
  const auto group = groups_.at(0);
  readers(1);
  serve();
  EXPECT_EQ(groups_.at(0), group) << "the others notice nothing";
  EXPECT_EQ(why(3), unsettled);
  EXPECT_EQ(time_until_plan(), 10ms);
  EXPECT_EQ(members(), 3U);
}

TEST_F(GroupKeeperTest, MakesAGroupForTheSecondReaderAHundredthOfASecondAfterThatCame) {
  readers(1);
  serve();
  go_on(200ms);
  ASSERT_EQ(members(), 0U);
  readers(1);
  serve();
  EXPECT_EQ(members(), 0U);
  EXPECT_EQ(time_until_plan(), 10ms);
  EXPECT_EQ(members(), 2U);
}

/// The readers of one process send their requests one after another.
TEST_F(GroupKeeperTest, TakesWhatAllReadersOfANewProcessAskForAsOneEvent) {
  readers(2, "height");
  serve();
  go_on(200ms);
  const auto before = groups_;
  int times = 0;
  for (const char* mask : {"width", "name", "data", "stamp"}) {
    reader(first_link + 100, mask);
    serve();
    EXPECT_EQ(groups_, before) << "the others notice nothing yet";
    times += go_on(2ms);
  }
  EXPECT_EQ(times, 0);
  EXPECT_EQ(go_on(3ms), 1);
  EXPECT_EQ(members(), 3U);
  ASSERT_EQ(merged_.size(), 1U) << "nobody is served alone";
  EXPECT_EQ(merged_[0].wanted.selection.mask(), fields<Image>("height, width, name, data, stamp"));
}

TEST_F(GroupKeeperTest, LeavesAReaderAloneForATenthOfASecondThatAsksForSomethingElseAfterThat) {
  readers(3);
  serve();
  go_on(SettlingTimes::gathering);
  routes_[2].selection = fields<Image>("height, data");
  serve();
  EXPECT_EQ(members(), 2U);
  EXPECT_EQ(why(3), unsettled);
  EXPECT_EQ(time_until_plan(), 100ms);
  EXPECT_EQ(members(), 3U);
}

TEST_F(GroupKeeperTest, TakesInAsNewWhoWasAwayForLong) {
  readers(3);
  serve();
  go_on(200ms);
  const core::Route last = routes_.back();
  for (const auto& [away, alone] : {std::pair{4900ms, 100ms}, std::pair{5100ms, 10ms}}) {
    routes_.pop_back();
    serve();
    go_on(away);
    routes_.push_back(last);
    serve();
    EXPECT_EQ(time_until_plan(), alone) << "away for " << away.count() << " ms";
    EXPECT_EQ(members(), 3U);
  }
}

/// Each plan makes new groups. Until the members of a new group have reported, each sample is also sent to
/// each of them separately.
TEST_F(GroupKeeperTest, TakesThoseInTogetherThatComeWithinATwentiethOfASecond) {
  readers(2);
  serve();
  go_on(200ms);
  int times = 0;
  for (int i = 0; i < 40; ++i) {
    readers(1);
    const auto before = groups_;
    serve();
    times += groups_ == before ? 0 : 1;
    times += go_on(1ms);
  }
  EXPECT_EQ(times, 1) << "the first one; the others have to wait";
  times = go_on(50ms);
  EXPECT_EQ(times, 1);
  EXPECT_EQ(members(), 42U);
}

TEST_F(GroupKeeperTest, LeavesAReaderAloneThatNeverAsksForTheSameForLong) {
  readers(3);
  readers(1, "height");
  serve();
  go_on(200ms);
  ASSERT_EQ(members(), 4U);
  routes_[3].selection = fields<Image>("width");
  serve();
  ASSERT_EQ(members(), 3U);
  const auto group = groups_.at(0);
  for (int i = 0; i < 50; ++i) {
    routes_[3].selection = fields<Image>(i % 2 == 0 ? "height" : "width");
    serve();
    EXPECT_EQ(why(4), unsettled);
    go_on(90ms);
    ASSERT_EQ(groups_.at(0), group) << "the others notice nothing, at change " << i;
  }
}

TEST_F(GroupKeeperTest, LeavesAReaderAloneForLongerEachTimeThatItsMaskChangesOnceMore) {
  readers(3);
  serve();
  go_on(200ms);
  std::vector<std::chrono::milliseconds> alone;
  for (int i = 0; i < 10; ++i) {
    routes_[2].selection = fields<Image>(i % 2 == 0 ? "height, data" : "*");
    serve();
    ASSERT_EQ(members(), 2U);
    alone.push_back(time_until_plan());
    EXPECT_EQ(members(), 3U);
  }
  const std::vector<std::chrono::milliseconds> expected{100ms, 100ms,  100ms,  200ms,  400ms,
                                                        800ms, 1600ms, 3200ms, 5000ms, 100ms};
  EXPECT_EQ(alone, expected) << "after five seconds without a change the earlier ones are forgotten";
}

TEST_F(GroupKeeperTest, GathersSettledReadersWhileAnotherNeverIs) {
  readers(1);
  serve();
  for (int i = 0; i < 12; ++i) {
    routes_[0].selection = fields<Image>(i % 2 == 0 ? "height" : "width");
    if (i == 5) readers(3);
    serve();
    go_on(20ms);
    EXPECT_EQ(members(), i < 5 ? 0U : 3U) << "at change " << i;
  }
}

TEST_F(GroupKeeperTest, LeavesReadersAloneThatComeAndLeaveWithEachSample) {
  readers(2);
  serve();
  go_on(200ms);
  const auto group = groups_.at(0);
  for (int i = 0; i < 500; ++i) {
    if (i % 2 == 0) {
      readers(1);
    } else {
      routes_.pop_back();
    }
    serve();
    go_on(1ms);
    ASSERT_EQ(groups_.at(0), group) << "the others notice nothing, at sample " << i;
  }
}

/// A group is made after ten milliseconds. Then each member needs an offer, and has to report the next
/// sample.
TEST_F(GroupKeeperTest, IsSettledAHundredthOfASecondAndOneReportAfterReadersCame) {
  readers(64);
  serve();
  EXPECT_EQ(go_on(SettlingTimes::gathering + 1ms), 1);
  ASSERT_EQ(members(), 64U);
  const std::shared_ptr<MulticastGroup> group = groups_.at(0);
  const auto publish_to_group = [&] {
    const std::uint64_t ordinal = group->next_ordinal(now_);
    for (std::size_t i = 0; i < members(); ++i) group->placed(i, ordinal, ordinal);
    return ordinal;
  };
  publish_to_group();
  keeper_->maintain(now_);
  std::size_t offers = 0;
  for (const auto& datagram : connections_.sent()) {
    const auto offer = parse_as<GroupOffer>(datagram);
    offers += offer && offer->address != 0 ? 1 : 0;
  }
  EXPECT_EQ(offers, 64U);
  const std::uint64_t heard = publish_to_group();
  for (std::size_t i = 0; i < members(); ++i)
    group->hear({7, group->name().number, group->farewell(i).member, heard}, now_);
  for (std::size_t i = 0; i < members(); ++i) EXPECT_TRUE(group->hears(i));
}

/// A reader that leaves and comes back counts as a changed request.
TEST_F(GroupKeeperTest, KnowsWhoComesBack) {
  readers(3);
  serve();
  go_on(200ms);
  int groups = 0;
  for (int i = 0; i < 100; ++i) {
    const core::Route last = routes_.back();
    routes_.pop_back();
    serve();
    go_on(10ms);
    routes_.push_back(last);
    serve();
    go_on(150ms);
    groups += static_cast<int>(members() / 3);
  }
  EXPECT_LE(groups, 6) << "in 16 s";
}

}  // namespace
}  // namespace sft::udp::test
