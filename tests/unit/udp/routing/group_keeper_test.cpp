// These tests check which readers of a writer are put into multicast groups.
#include "tests/support/parse_datagram.h"
#include "tests/unit/udp/routing/group_keeper_fixture.h"
#include "udp_transport/multicast/divisions.h"

namespace sft::udp::test {
namespace {

TEST_F(GroupKeeperTest, PutsReadersOfAnyNumberOfMasksIntoOneGroup) {
  const std::vector<std::string> small{"stamp.sec", "stamp.nanosec", "name", "height", "width"};
  for (unsigned number = 0; number < 32; ++number) {
    std::string mask = "data";
    for (std::size_t i = 0; i < small.size(); ++i) {
      if ((number >> i & 1) != 0) mask += ", " + small[i];
    }
    readers(1, mask.c_str());
  }
  serve();
  go_on(110ms);
  EXPECT_EQ(members(), 32U);
  EXPECT_EQ(groups_.size(), 1U);
  EXPECT_TRUE(why(1).find(", which adds ") != std::string::npos) << why(1);
  EXPECT_EQ(why(32).find(", which adds "), std::string::npos) << "it asks for everything: " << why(32);
}

/// If the keeper always had urgent work, the agent would call it a thousand times per second.
TEST_F(GroupKeeperTest, HasNoDutyOnceNothingHasToBeDone) {
  const auto is_in_a_hurry = [&] { return keeper_->next_duty(now_) != GroupKeeper::Time::max(); };
  EXPECT_FALSE(is_in_a_hurry());
  readers(1);
  serve();
  go_on(50ms);
  EXPECT_FALSE(is_in_a_hurry()) << "one reader is no group";
  readers(1);
  serve();
  EXPECT_EQ(keeper_->next_duty(now_), now_ + SettlingTimes::gathering);
  go_on(SettlingTimes::gathering + 1ms);
  ASSERT_EQ(members(), 2U);
  for (const auto& group : groups_) {  // The group is offered to reliable members after they have places.
    const std::uint64_t ordinal = group->next_ordinal(now_);
    for (std::size_t i = 0; i < 2; ++i) group->placed(i, ordinal, ordinal);
  }
  keeper_->maintain(now_);
  EXPECT_TRUE(is_in_a_hurry());
  for (int i = 0; i < 100; ++i, now_ += 1ms) keeper_->maintain(now_);
  EXPECT_FALSE(is_in_a_hurry()) << "nobody has reported, but probes end";
  keeper_->maintain(now_ += 1s);
  go_on(2s);
  for (int i = 0; i < 100; ++i, now_ += 1ms) keeper_->maintain(now_);
  EXPECT_FALSE(is_in_a_hurry());
}

TEST_F(GroupKeeperTest, MeasuresNewFieldsBeforeItGathersTheirReaders) {
  readers(2, "height");
  serve();
  now_ += 110ms;
  publish_often("height");
  EXPECT_TRUE(keeper_->replan(now_));
  serve();
  EXPECT_EQ(members(), 2U);
  readers(2, "data");
  serve();
  now_ += 110ms;
  EXPECT_FALSE(keeper_->replan(now_));
  serve();
  EXPECT_EQ(members(), 2U);
  publish_often("height, data");
  EXPECT_TRUE(keeper_->replan(now_)) << "the next sample is measured";
  serve();
  EXPECT_EQ(members(), 4U);
}

TEST_F(GroupKeeperTest, LooksOnceASecondWhetherAnotherPlanIsBetter) {
  readers(2);
  serve();
  publish(10);
  now_ += 110ms;
  EXPECT_TRUE(keeper_->replan(now_)) << "since why() tells something else";
  serve();
  EXPECT_EQ(members(), 0U) << "one sample in a tenth of a second is worth no group";
  EXPECT_EQ(why(1), "alone: a group would put hardly fewer bytes on the wire");
  for (int i = 0; i < 2000; ++i) publish();
  EXPECT_FALSE(keeper_->replan(now_ + 999ms));
  EXPECT_TRUE(keeper_->replan(now_ + 1000ms));
}

TEST_F(GroupKeeperTest, MakesNoGroupForATopicThatIsSeldomPublished) {
  readers(3);
  serve();
  for (int i = 0; i < 20; ++i, now_ += 1s) {
    publish(100);
    if (keeper_->replan(now_)) serve();
    EXPECT_EQ(members(), 0U) << i;
  }
}

TEST_F(GroupKeeperTest, SendsTheGroupTheUnionOfItsMembersMasks) {
  readers(2, "height");
  readers(2, "width, stamp");
  serve();
  go_on(300ms);
  ASSERT_EQ(groups_.size(), 1U);
  ASSERT_EQ(merged_.size(), 1U) << "nobody is served alone";
  EXPECT_EQ(merged_[0].wanted.selection.mask(), fields<Image>("height, width, stamp"));
  EXPECT_EQ(members(), 4U);
}

TEST_F(GroupKeeperTest, LeavesAReaderAloneWhoseMaximumRateNobodyElseHas) {
  readers(3);
  routes_[2].min_period_us = 10'000;
  routes_[2].gate = std::make_shared<core::Gate>(10'000);
  serve();
  go_on(200ms);
  EXPECT_EQ(members(), 2U);
  EXPECT_EQ(
      why(3),
      "alone: no other host that could be in a group asks for the same at its rate or under its conditions");
  ASSERT_EQ(merged_.size(), 2U);
  EXPECT_EQ(merged_[1].gate, routes_[2].gate);
  EXPECT_EQ(merged_[1].destinations.size(), 1U);
}

TEST_F(GroupKeeperTest, MakesAGroupOfReadersWithOneMaximumRateBesideThatOfTheOthers) {
  readers(6);
  const auto gate = std::make_shared<core::Gate>(10'000);
  for (const std::size_t rated : {3, 4, 5}) {
    routes_[rated].min_period_us = 10'000;
    routes_[rated].gate = gate;
  }
  serve();
  go_on(200ms);
  EXPECT_EQ(groups_.size(), 2U);
  EXPECT_EQ(members(), 6U);
  ASSERT_EQ(merged_.size(), 2U);
  for (const RouteBundle& bundle : merged_) {
    const bool rated = bundle.gate != nullptr;
    EXPECT_EQ(bundle.gate, rated ? gate : nullptr);
    EXPECT_EQ(bundle.wanted.min_period_us, rated ? 10'000U : 0U);
    EXPECT_EQ(bundle.destinations.size(), 3U);
  }
}

TEST_F(GroupKeeperTest, LeavesAHostAloneWhereOnlyOneOfSeveralReadersHasAMaximumRate) {
  readers(2);
  for (const std::uint32_t host : {1, 2}) {
    reader(first_link + 100 + host);
    reader(first_link + 100 + host).gate = std::make_shared<core::Gate>(10'000);
  }
  serve();
  go_on(200ms);
  EXPECT_EQ(members(), 2U);
  EXPECT_EQ(why(3), "alone: its readers ask for different samples, or for different fields of some");
}

TEST_F(GroupKeeperTest, NoticesNothingOfAHostWhereAReaderWithAMaximumRateComesAndGoes) {
  readers(4);
  serve();
  go_on(200ms);
  ASSERT_EQ(members(), 4U);
  int plans = 0;
  for (int i = 0; i < 50; ++i) {
    reader(first_link + 10).gate = std::make_shared<core::Gate>(10'000);
    serve();
    plans += go_on(60ms);
    routes_.pop_back();
    serve();
    plans += go_on(60ms);
  }
  EXPECT_LE(plans, 8) << "it is unsettled soon";
  EXPECT_EQ(members(), 3U);
}

TEST_F(GroupKeeperTest, LeavesAGroupAtItsAddressWhenAnotherOneComes) {
  readers(2, "data[::3]");
  serve();
  go_on(200ms);
  ASSERT_EQ(groups_.size(), 1U);
  const auto first = groups_[0];
  const auto gate = std::make_shared<core::Gate>(10'000);
  for (std::uint32_t i = 0; i < 5; ++i) {
    reader(first_link + 100 + i).gate = gate;
    serve();
    go_on(1100ms);
    if (i == 0) continue;
    ASSERT_EQ(groups_.size(), 2U);
    EXPECT_TRUE(groups_[0] == first || groups_[1] == first);
    EXPECT_NE(groups_[0]->name().address, groups_[1]->name().address);
  }
}

TEST_F(GroupKeeperTest, MakesAGroupOnceSamplesAreSentMoreOften) {
  readers(2);
  serve();
  go_on_every(33ms, 5s);
  ASSERT_EQ(members(), 0U) << "there is too little to gain";
  go_on_every(19ms, 3s);
  EXPECT_EQ(members(), 2U);
}

TEST_F(GroupKeeperTest, MakesNoGroupForAMaximumRateThatLetsHardlyAnythingPass) {
  for (const std::uint32_t period_us : {10'000, 1'000'000}) {
    restart(Multicast::automatic);
    routes_.clear();
    readers(2);
    const auto gate = std::make_shared<core::Gate>(period_us);
    for (core::Route& route : routes_) {
      route.gate = gate;
      route.min_period_us = period_us;
    }
    serve();
    go_on(2s);
    EXPECT_EQ(members(), period_us == 10'000 ? 2U : 0U);
  }
}

/// Switches remove members of a group without traffic. So each of the rare samples would have to be sent to
/// each member separately, like the first one.
TEST_F(GroupKeeperTest, MakesNoGroupForConditionsThatLetHardlyAnythingPass) {
  for (const bool often : {true, false}) {
    restart(Multicast::automatic);
    routes_.clear();
    readers(2, "* @ changed(height)");
    const auto gate = std::make_shared<core::Gate>(often ? 10'000 : 5'000'000, detail::Conditions(),
                                                   routes_[0].selection.gate_hash());
    for (core::Route& route : routes_) route.gate = gate;
    serve();
    go_on(200ms);
    for (int i = 0; i < 100; ++i) {
      go_on(200ms);
      ASSERT_EQ(members(), often ? 2U : 0U) << i;
    }
  }
}

TEST_F(GroupKeeperTest, GivesUpAGroupForConditionsThatLetHardlyAnythingPassAnyMore) {
  readers(2, "* @ changed(height)");
  const auto hash = routes_[0].selection.gate_hash();
  const auto gate = std::make_shared<core::Gate>(0, detail::Conditions(), hash);
  for (core::Route& route : routes_) route.gate = gate;
  serve();
  go_on(300ms);
  ASSERT_EQ(members(), 2U);
  anything_passes_ = false;
  go_on(15s);
  EXPECT_EQ(members(), 0U);
  anything_passes_ = true;
  go_on(2s);
  EXPECT_EQ(members(), 2U);
}

TEST_F(GroupKeeperTest, MakesAGroupSoonForAMaximumRateThatOneReaderHadForLongBeforeAnotherCame) {
  const auto gate = std::make_shared<core::Gate>(10'000);
  readers(1);
  routes_[0].gate = gate;
  serve();
  for (const auto end = now_ + 10min; now_ < end; now_ += 10ms) publish();
  readers(1);
  routes_[1].gate = gate;
  serve();
  go_on(200ms);
  EXPECT_EQ(members(), 2U);
}

TEST_F(GroupKeeperTest, WhoChangesItsMaximumRateTakesNoGroupFromOthers) {
  std::vector<std::shared_ptr<core::Gate>> gates;
  for (std::uint32_t i = 0; i <= some_samples_groups_max; ++i)
    gates.push_back(std::make_shared<core::Gate>(10'000 + i));
  for (const auto& gate : gates) {
    readers(3);
    for (std::size_t i = routes_.size() - 3; i < routes_.size(); ++i) routes_[i].gate = gate;
    for (std::size_t i = routes_.size() - 3; i < routes_.size(); ++i)
      routes_[i].min_period_us = gate->min_period_us();
    serve();
    go_on(300ms);
  }
  ASSERT_EQ(groups_.size(), some_samples_groups_max);
  routes_[0].gate = gates.back();
  routes_[0].min_period_us = gates.back()->min_period_us();
  serve();
  go_on(2s);
  EXPECT_EQ(groups_.size(), some_samples_groups_max);
  EXPECT_EQ(members(), 3 * some_samples_groups_max - 1);
}

TEST_F(GroupKeeperTest, TakesAMemberOutOfItsGroupWhenItsMaximumRateChangesAndIntoAnotherOneOnceItHasSettled) {
  readers(4);
  const auto often = std::make_shared<core::Gate>(10'000), seldom = std::make_shared<core::Gate>(20'000);
  for (const std::size_t i : {0, 1, 2, 3}) routes_[i].gate = i < 2 ? often : seldom;
  serve();
  go_on(200ms);
  ASSERT_EQ(groups_.size(), 2U);
  routes_[1].gate = seldom;
  serve();
  EXPECT_EQ(members(), 2U) << "of those that are left, one is alone";
  EXPECT_EQ(why(2), unsettled);
  go_on(300ms);
  EXPECT_EQ(members(), 3U);
}

TEST_F(GroupKeeperTest, TakesAMemberOutOfItsGroupOnceItHasAMaximumRate) {
  readers(3);
  serve();
  go_on(200ms);
  ASSERT_EQ(members(), 3U);
  routes_[1].gate = std::make_shared<core::Gate>(10'000);
  serve();
  EXPECT_EQ(members(), 2U);
  routes_[2].gate = routes_[1].gate;
  serve();
  EXPECT_EQ(members(), 0U) << "one alone is no group";
}

TEST_F(GroupKeeperTest, LeavesReadersAloneThatAreSentMoreThanTheGroup) {
  readers(4);
  routes_[2].history = 3;
  routes_[3].fallback = true;
  serve();
  go_on(200ms);
  EXPECT_EQ(members(), 2U);
  EXPECT_EQ(why(3), "alone: a reader there is sent what was retained");
  EXPECT_EQ(why(4), "alone: a reader there is served in shared memory");
  EXPECT_FALSE(merged_.front().fallback);
  EXPECT_TRUE(merged_.back().fallback);
}

TEST_F(GroupKeeperTest, LeavesReadersAloneThatNoGoodLinkLeadsTo) {
  readers(2);
  reader(first_link + 1);
  reader(wireless + 10);
  reader(0x0b000001);
  const core::IpAddress::Bytes documentation{0x20, 0x01, 0x0d, 0xb8, 1};
  std::get<core::UdpAddress>(reader(1).destination).ip = core::IpAddress{documentation};
  serve();
  go_on(200ms);
  EXPECT_EQ(members(), 2U);
  EXPECT_EQ(why(3), "alone: it is on this host");
  EXPECT_EQ(why(4), "alone: interface wlan0 is wireless");
  EXPECT_EQ(why(5), "alone: it is not on a link of this host");
  EXPECT_EQ(why(6), "alone: it is reached by IPv6");
  EXPECT_EQ(why(7), "") << "nobody of that name is served";
}

TEST_F(GroupKeeperTest, HasAGroupForEachLink) {
  for (std::uint32_t host = 10; host < 13; ++host) {
    reader(first_link + host);
    reader(second_link + host);
  }
  serve();
  go_on(200ms);
  ASSERT_EQ(groups_.size(), 2U);
  ASSERT_EQ(connected_.size(), 2U);
  EXPECT_NE(connected_[0].own, connected_[1].own);
  EXPECT_NE(connected_[0].group, connected_[1].group);
  for (const auto& group : groups_) EXPECT_EQ(group->members().size(), 3U);
}

TEST_F(GroupKeeperTest, GathersReadersOnItsOwnHostOnlyIfMulticastIsAllowedEverywhere) {
  reader(first_link + 1);
  reader(first_link + 1).destination = core::UdpAddress{first_link + 1, 1001, 1'000'000};
  serve();
  EXPECT_EQ(keeper_->sizes(), nullptr) << "there is nothing to be measured";
  EXPECT_EQ(go_on(200ms), 0);
  restart(Multicast::everywhere);
  serve();
  go_on(200ms);
  EXPECT_EQ(members(), 2U);
}

TEST_F(GroupKeeperTest, MakesNoGroupIfMulticastIsOff) {
  restart(Multicast::off);
  readers(3);
  serve();
  EXPECT_EQ(go_on(200ms), 0);
  EXPECT_EQ(why(1), "alone: multicast is off by option");
}

TEST_F(GroupKeeperTest, NamesNoOtherReaderIfOneIsAlone) {
  readers(1);
  serve();
  EXPECT_NE(keeper_->sizes(), nullptr) << "a reader may come";
  EXPECT_EQ(why(1), "alone: nobody else could be in a group with it");
}

TEST_F(GroupKeeperTest, GoesOnMeasuringWhenOtherFieldsAreAskedFor) {
  readers(2, "height");
  serve();
  const auto sizes = keeper_->sizes();
  readers(1, "name");
  serve();
  EXPECT_EQ(keeper_->sizes(), sizes);
}

TEST_F(GroupKeeperTest, MeasuresSamplesEveryTenthOfASecond) {
  readers(2);
  serve();
  const FieldMask all = fields<Image>("*");
  publish(100);
  const double first = keeper_->sizes()->bytes_of(all);
  now_ += 99ms;
  publish(1000);
  EXPECT_EQ(keeper_->sizes()->bytes_of(all), first);
  now_ += 1ms;
  publish(1000);
  EXPECT_EQ(keeper_->sizes()->bytes_of(all), first + 225) << "a new value counts for a quarter";
}

TEST_F(GroupKeeperTest, HasNoGroupForTenSecondsAfterSamplesWerePublishedTogether) {
  readers(3);
  serve();
  go_on(200ms);
  ASSERT_EQ(members(), 3U);
  publish(1000, true);
  ASSERT_TRUE(keeper_->replan(now_)) << "at once";
  serve();
  EXPECT_EQ(members(), 0U);
  EXPECT_EQ(why(1), "alone: samples that are published together share datagrams");
  now_ += 9999ms;
  serve();
  EXPECT_EQ(keeper_->sizes(), nullptr);
  now_ += 1ms;
  serve();
  go_on(200ms);
  EXPECT_EQ(members(), 3U);
}

TEST_F(GroupKeeperTest, LeavesReadersAloneForAMinuteIfTheyHearNothing) {
  readers(3);
  serve();
  go_on(200ms);
  ASSERT_EQ(members(), 3U);
  const auto send_and_maintain = [&] {
    for (const auto& group : groups_) {
      const std::uint64_t ordinal = group->next_ordinal(now_);
      for (std::size_t i = 0; i < 3; ++i) group->placed(i, ordinal, ordinal);
      for (std::size_t i = 0; i < 2; ++i)
        group->hear({7, group->name().number, group->farewell(i).member, ordinal}, now_);
    }
    keeper_->maintain(now_);
  };
  const auto offered = now_;
  for (; !keeper_->replan(now_) && now_ < offered + 1min; now_ += 10ms) send_and_maintain();
  EXPECT_GT(now_ - offered, 4s);
  EXPECT_LT(now_ - offered, 10s) << "nine offers, of which the last are 2 s apart";
  serve();
  EXPECT_EQ(members(), 2U);
  EXPECT_EQ(why(3), "alone: no multicast comes to it");
  now_ += 59s;
  serve();
  EXPECT_EQ(why(3), "alone: no multicast comes to it");
  now_ += 1s;
  serve();
  EXPECT_EQ(members(), 3U) << "it is tried again";
}

TEST_F(GroupKeeperTest, WithdrawsAGroupASecondAfterItsEnd) {
  readers(2);
  serve();
  go_on(200ms);
  ASSERT_EQ(members(), 2U);
  const auto first = groups_[0];
  readers(1);
  serve();
  go_on(110ms);
  ASSERT_EQ(members(), 3U);
  EXPECT_GT(groups_[0]->name().number, first->name().number) << "others make another group";
  const auto over = now_ - 10ms;
  keeper_->maintain(over + 900ms);
  EXPECT_TRUE(withdrawn(*first).empty()) << "something of it may be under way";
  keeper_->maintain(over + 1010ms);
  EXPECT_EQ(withdrawn(*first), (std::vector<std::size_t>{0, 1}));
  keeper_->maintain(over + 2s);
  EXPECT_EQ(withdrawn(*first).size(), 2U) << "once";
}

TEST_F(GroupKeeperTest, WithdrawsTheLastGroupOfAMemberAndWithItThoseBefore) {
  readers(2);
  serve();
  go_on(200ms);
  const auto first = groups_.at(0);
  readers(1);
  serve();
  go_on(200ms);
  ASSERT_EQ(members(), 3U);
  const auto second = end_of_group();
  ASSERT_NE(second, first);
  keeper_->maintain(now_ + 999ms);
  EXPECT_TRUE(withdrawn(*second).empty()) << "something of it may be under way";
  keeper_->maintain(now_ + 1s);
  EXPECT_TRUE(withdrawn(*first).empty());
  EXPECT_EQ(withdrawn(*second), (std::vector<std::size_t>{0, 1, 2}));
}

TEST_F(GroupKeeperTest, WithdrawsALargeGroupFromEightMembersOrAnEighthAtATime) {
  for (const std::uint32_t size : {20U, 200U}) {
    restart(Multicast::automatic);
    readers(size);
    serve();
    go_on(200ms);
    ASSERT_EQ(members(), size);
    const auto group = end_of_group();
    now_ += 1s;
    std::size_t reported = 0;
    for (std::size_t times = 0; reported < size; ++times) {
      ASSERT_LT(times, 20U) << reported << " of " << size;
      keeper_->maintain(now_);
      const std::size_t rest = size - reported;
      EXPECT_EQ(withdrawn(*group).size(), reported + std::min(rest, std::max<std::size_t>(8, rest / 8)));
      reported = withdrawn(*group).size();
    }
    keeper_->maintain(now_);
    EXPECT_EQ(withdrawn(*group).size(), size) << "once";
  }
}

TEST_F(GroupKeeperTest, KeepsAGroupWhoseMembersStay) {
  readers(3);
  serve();
  go_on(200ms);
  const auto group = groups_.at(0);
  for (int i = 0; i < 3; ++i) {
    go_on(1s);
    serve();
    EXPECT_EQ(groups_.at(0), group);
  }
  EXPECT_EQ(connected_.size(), 1U);
}

TEST_F(GroupKeeperTest, ReplacesABrokenGroup) {
  readers(2);
  serve();
  go_on(200ms);
  const auto group = groups_.at(0);
  group->placed(0, 1, 1);
  group->placed(0, 2, 5);
  ASSERT_TRUE(group->broken());
  ASSERT_TRUE(keeper_->replan(now_)) << "at once";
  serve();
  EXPECT_NE(groups_.at(0), group);
  EXPECT_FALSE(keeper_->replan(now_));
}

TEST_F(GroupKeeperTest, FitsDatagramsToTheNarrowestPathAndTheSmallestBuffer) {
  readers(3);
  serve();
  routes_[1].destination = core::UdpAddress{0x0a000063, 1000, 300'000};
  serve();
  go_on(200ms);
  ASSERT_EQ(groups_.size(), 1U);
  std::uint32_t smallest = UINT32_MAX;
  for (const auto& member : groups_[0]->members())
    smallest = std::min(smallest, member.lane->destination().window().receive_buffer_bytes());
  EXPECT_EQ(smallest, 300'000U);
  EXPECT_EQ(groups_[0]->lane()->destination().window().receive_buffer_bytes(), smallest);
  EXPECT_LE(connected_.at(0).datagram_bytes,
            groups_[0]->members()[0].lane->destination().path().datagram_bytes());
}

TEST_F(GroupKeeperTest, UsesOnlyAddressesOfItsRange) {
  for (std::uint32_t writer = 1; writer <= 50; ++writer) {
    restart(Multicast::automatic, writer * 2654435761U);
    routes_.clear();
    reader(first_link + 10);
    reader(first_link + 11);
    serve();
    go_on(150ms);
    ASSERT_EQ(groups_.size(), 1U);
    const std::uint32_t address = groups_[0]->name().address;
    ASSERT_GE(address, 0xefff1000U);  // the lowest address, 239.255.16.0
    ASSERT_LE(address, 0xefffefffU);  // the highest address, 239.255.239.255
  }
}

TEST_F(GroupKeeperTest, MakesNoGroupForATypeWithTooManyFields) {
  for (const std::size_t leaves : {2048U, 2049U}) {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < leaves; ++i) names.push_back("m" + std::to_string(i));
    std::vector<StructType::Member> members;
    for (const std::string& name : names)
      members.push_back({.name = name, .kind = StructType::Member::Kind::uint8});
    const StructType large("test::Large", members);
    const TypeSupport type(large);
    keeper_ = std::make_unique<GroupKeeper>(setup(type, Multicast::automatic, 7));
    routes_.clear();
    for (std::uint32_t host = 10; host < 12; ++host)
      reader(first_link + host).selection = FieldMask::full(leaves);
    serve();
    EXPECT_EQ(why(1), leaves > 2048 ? "alone: its type has too many fields" : unsettled);
    keeper_ = nullptr;
  }
}

}  // namespace
}  // namespace sft::udp::test
