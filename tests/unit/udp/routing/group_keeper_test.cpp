// These tests check which readers of a writer are put into multicast groups, and when.
#include "udp_transport/routing/group_keeper.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/seam/rate_gate.h"
#include "tests/unit/udp/connections.h"
#include "tests/unit/udp/messages.h"
#include "udp_transport/flow/destination_directory.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;
using test::fields;
using test::Image;

constexpr const char* restless = "alone: it asks for that only since just now, or often for something else";

/// This host has 10.0.0.1 and 10.0.1.1 on two cables, and 10.0.2.1 on a wireless interface.
constexpr std::uint32_t first_link = 0x0a000000, second_link = 0x0a000100, wireless = 0x0a000200;
constexpr std::uint32_t netmask = 0xffffff00;

class GroupKeeperTest : public testing::Test {
 protected:
  GroupKeeperTest() { restart(Multicast::automatic); }

  void restart(Multicast use, std::uint32_t writer = 7) {
    keeper_ = std::make_unique<GroupKeeper>(setup(test::type_support<Image>().type(), use, writer));
  }

  GroupKeeper::Setup setup(const StructType& type, Multicast use, std::uint32_t writer) {
    GroupKeeper::Setup setup;
    setup.writer = writer;
    setup.type = &type;
    setup.use = use;
    setup.report_port = 9;
    setup.tally = tally_;
    setup.roster = &roster_;
    setup.connect = [this](std::uint32_t group, std::uint32_t own, std::size_t datagram_bytes) {
      connected_.push_back({group, own, datagram_bytes});
      DestinationLimits limits;
      limits.datagram_bytes = datagram_bytes;
      return std::make_shared<Destination>(SocketAddress{core::IpAddress(group), group_port}, limits, 0,
                                           connections_.connect());
    };
    setup.links = [](Multicast) {
      return std::vector<MulticastLink>{{"eth0", first_link + 1, netmask},
                                        {"eth1", second_link + 1, netmask},
                                        {"wlan0", wireless + 1, netmask, "interface wlan0 is wireless"}};
    };
    return setup;
  }

  core::Route& reader(std::uint32_t ip, const char* mask = "*") {
    core::Route route{routes_.size() + 1, core::UdpAddress{ip, 1000, 1'000'000}, fields<Image>(mask)};
    route.reliable = true;
    return routes_.emplace_back(std::move(route));
  }
  void readers(std::uint32_t count, const char* mask = "*") {
    for (std::uint32_t i = 0; i < count; ++i) reader(first_link + 10 + next_host_++, mask);
  }

  /// Serves the routes as a table of routes is made.
  void serve() {
    merged_ = bundle_routes(routes_, destinations_);
    keeper_->merge(merged_, now_);
    groups_.clear();
    for (const RouteBundle& bundle : merged_) {
      if (!bundle.multicast) continue;
      std::vector<MulticastGroup::Member> members;
      for (const auto& to : bundle.destinations) members.push_back({lane(to), channel(to)});
      groups_.push_back(keeper_->find(*bundle.multicast, std::move(members)));
    }
    keeper_->merged(now_);
  }
  void publish(std::size_t data_bytes = 1000, bool together = false) {
    publish(data_bytes, together, fields<Image>("*"));
  }
  void publish_often(const char* mask) {
    for (int i = 0; i < 1000; ++i) publish(1000, false, fields<Image>(mask));
  }
  void publish(std::size_t data_bytes, bool together, const FieldMask& all) {
    if (keeper_->sizes() == nullptr) return;
    const Image image = test::make_image(data_bytes);
    const core::SampleHandle sample = memory_->take(test::sample_bytes(image, all));
    test::fill(*sample, image, all, 7, 1);
    keeper_->sizes()->measure(core::state_of(*sample, test::type_support<Image>().slots()), now_, together);
  }
  /// Publishes at 1 kHz and makes routes anew whenever the keeper wants that. Returns how often it did.
  int go_on(std::chrono::milliseconds time) {
    int times = 0;
    for (const auto end = now_ + time; now_ < end; now_ += 1ms) {
      publish();
      if (!keeper_->replan(now_)) continue;
      serve();
      ++times;
    }
    return times;
  }
  std::size_t members() const {
    std::size_t count = 0;
    for (const auto& group : groups_) count += group->members().size();
    return count;
  }
  std::string why(core::EndpointId reader) const { return keeper_->why(reader); }

  struct Connected {
    std::uint32_t group, own;
    std::size_t datagram_bytes;
  };
  GroupKeeper::Time now_{1h};
  std::vector<core::Route> routes_;
  std::vector<RouteBundle> merged_;
  std::vector<std::shared_ptr<MulticastGroup>> groups_;
  std::vector<Connected> connected_;
  test::Connections connections_;
  std::unique_ptr<GroupKeeper> keeper_;

 private:
  std::shared_ptr<Lane> lane(const std::shared_ptr<Destination>& to) {
    std::shared_ptr<Lane>& known = lanes_[to.get()];
    if (known == nullptr) known = std::make_shared<Lane>(to, 4, tally_);
    return known;
  }
  std::shared_ptr<Channel> channel(const std::shared_ptr<Destination>& to) {
    std::shared_ptr<Channel>& known = channels_[to.get()];
    if (known == nullptr)
      known = std::make_shared<Channel>(7, static_cast<std::uint32_t>(channels_.size()), to, tally_, 9);
    return known;
  }

  std::uint32_t next_host_ = 0;
  std::shared_ptr<core::BufferPool> memory_ = core::BufferPool::make(std::size_t{1} << 20);
  std::shared_ptr<WriterTally> tally_ = std::make_shared<WriterTally>();
  DestinationDirectory destinations_{DestinationLimits{}, connections_.connect()};
  GroupRoster roster_;
  std::map<const Destination*, std::shared_ptr<Lane>> lanes_;
  std::map<const Destination*, std::shared_ptr<Channel>> channels_;
};

TEST_F(GroupKeeperTest, GathersThoseThatAskForTheSameOnceTheyAreCalm) {
  readers(3);
  serve();
  EXPECT_EQ(why(1), restless);
  EXPECT_EQ(go_on(100ms), 0);
  EXPECT_EQ(go_on(1ms), 1);
  ASSERT_EQ(groups_.size(), 1U);
  EXPECT_EQ(groups_[0]->members().size(), 3U);
  ASSERT_EQ(merged_.size(), 1U);
  EXPECT_EQ(merged_[0].destinations.size(), 3U);
  EXPECT_EQ(merged_[0].readers.size(), 3U);
  EXPECT_EQ(merged_[0].reliable.size(), 3U);
  EXPECT_TRUE(why(2).starts_with("group 239.255.")) << why(2);
  EXPECT_TRUE(why(2).ends_with(" of 3; it has not reported any sample of the group yet, or no more"));
}

TEST_F(GroupKeeperTest, GathersCalmReadersWithTheFirstSample) {
  readers(3);
  serve();
  now_ += 10s;
  EXPECT_FALSE(keeper_->replan(now_));
  EXPECT_EQ(go_on(1ms), 1);
  EXPECT_EQ(members(), 3U);
}

TEST_F(GroupKeeperTest, TakesInWhoComesLaterOnceItIsCalm) {
  readers(2);
  serve();
  go_on(200ms);
  ASSERT_EQ(members(), 2U);
  const auto group = groups_.at(0);
  readers(1);
  serve();
  EXPECT_EQ(groups_.at(0), group) << "the others notice nothing";
  EXPECT_EQ(why(3), restless);
  EXPECT_EQ(go_on(100ms), 0);
  EXPECT_EQ(go_on(1ms), 1);
  EXPECT_EQ(members(), 3U);
}

TEST_F(GroupKeeperTest, MakesAGroupForTheSecondReaderOnceThatIsCalm) {
  readers(1);
  serve();
  go_on(200ms);
  ASSERT_EQ(members(), 0U);
  readers(1);
  serve();
  EXPECT_EQ(members(), 0U);
  EXPECT_EQ(go_on(101ms), 1);
  EXPECT_EQ(members(), 2U);
}

/// Each plan makes other groups, and until their members have reported they are sent everything alone, too.
TEST_F(GroupKeeperTest, TakesThoseInTogetherThatComeWithinATwentiethOfASecond) {
  readers(2);
  serve();
  go_on(200ms);
  int times = 0;
  for (int i = 0; i < 40; ++i) {
    readers(1);
    serve();
    times += go_on(1ms);
  }
  EXPECT_EQ(times, 0);
  times = go_on(61ms);
  EXPECT_EQ(times, 1) << "the first one is calm; the others have to wait";
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
  routes_[3].mask = fields<Image>("width");
  serve();
  ASSERT_EQ(members(), 3U);
  const auto group = groups_.at(0);
  for (int i = 0; i < 50; ++i) {
    routes_[3].mask = fields<Image>(i % 2 == 0 ? "height" : "width");
    serve();
    EXPECT_EQ(why(4), restless);
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
    routes_[2].mask = fields<Image>(i % 2 == 0 ? "height, data" : "*");
    serve();
    const auto since = now_;
    while (members() < 3 && now_ - since < 10s) go_on(1ms);
    alone.push_back(std::chrono::ceil<std::chrono::milliseconds>(now_ - since) - 1ms);
  }
  const std::vector<std::chrono::milliseconds> expected{100ms, 100ms,  100ms,  200ms,  400ms,
                                                        800ms, 1600ms, 3200ms, 5000ms, 100ms};
  EXPECT_EQ(alone, expected) << "after five seconds without a change the earlier ones are forgotten";
}

TEST_F(GroupKeeperTest, GathersCalmReadersWhileAnotherNeverIs) {
  readers(1);
  serve();
  for (int i = 0; i < 12; ++i) {
    routes_[0].mask = fields<Image>(i % 2 == 0 ? "height" : "width");
    if (i == 5) readers(3);
    serve();
    go_on(20ms);
  }
  EXPECT_EQ(members(), 3U) << "140 ms after they came";
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

/// A hundred milliseconds, then an offer to each member, and its report of the first sample behind that.
TEST_F(GroupKeeperTest, IsSettledATenthOfASecondAndOneReportAfterReadersCame) {
  readers(64);
  serve();
  EXPECT_EQ(go_on(CalmWatch::calm_after + 1ms), 1);
  ASSERT_EQ(members(), 64U);
  const std::shared_ptr<MulticastGroup> group = groups_.at(0);
  const auto publish_to_group = [&] {
    const std::uint64_t ordinal = group->next_ordinal(now_);
    for (std::size_t i = 0; i < members(); ++i) group->placed(i, ordinal, ordinal);
    return ordinal;
  };
  publish_to_group();
  keeper_->tend(now_);
  std::size_t offers = 0;
  for (const auto& datagram : connections_.sent()) {
    const auto offer = parse_group_offer(datagram);
    offers += offer && offer->address != 0 ? 1 : 0;
  }
  EXPECT_EQ(offers, 64U);
  const std::uint64_t heard = publish_to_group();
  for (std::size_t i = 0; i < members(); ++i)
    group->hear({7, group->name().number, group->farewell(i).member, heard}, now_);
  for (std::size_t i = 0; i < members(); ++i) EXPECT_TRUE(group->hears(i));
}

/// To come back is a change.
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

TEST_F(GroupKeeperTest, GathersAnyNumberOfMasksInWhatCostsNoMoreThanOneGroupOfAll) {
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

TEST_F(GroupKeeperTest, WaitsForASampleWithFieldsThatWereNeverSent) {
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

TEST_F(GroupKeeperTest, GathersNobodyAroundATopicThatIsSeldomPublished) {
  readers(3);
  serve();
  for (int i = 0; i < 20; ++i, now_ += 1s) {
    publish(100);
    if (keeper_->replan(now_)) serve();
    EXPECT_EQ(members(), 0U) << i;
  }
}

TEST_F(GroupKeeperTest, SendsTheGroupTheUnionOfWhatItsMembersAskFor) {
  readers(2, "height");
  readers(2, "width, stamp");
  serve();
  go_on(300ms);
  ASSERT_EQ(groups_.size(), 1U);
  ASSERT_EQ(merged_.size(), 1U) << "nobody is served alone";
  EXPECT_EQ(merged_[0].wanted.mask, fields<Image>("height, width, stamp"));
  EXPECT_EQ(members(), 4U);
}

TEST_F(GroupKeeperTest, LeavesReadersWithAMaximumRateAlone) {
  readers(3);
  routes_[2].min_period_us = 10'000;
  routes_[2].gate = std::make_shared<core::RateGate>(10'000);
  serve();
  go_on(200ms);
  EXPECT_EQ(members(), 2U);
  EXPECT_EQ(why(3), "alone: a reader there has a maximum rate");
  ASSERT_EQ(merged_.size(), 2U);
  EXPECT_EQ(merged_[1].gate, routes_[2].gate);
  EXPECT_EQ(merged_[1].destinations.size(), 1U);
}

TEST_F(GroupKeeperTest, LeavesAMemberAloneFromTheMomentThatItHasAMaximumRate) {
  readers(3);
  serve();
  go_on(200ms);
  ASSERT_EQ(members(), 3U);
  routes_[1].gate = std::make_shared<core::RateGate>(10'000);
  serve();
  EXPECT_EQ(members(), 2U);
  routes_[2].gate = routes_[1].gate;
  serve();
  EXPECT_EQ(members(), 0U) << "one alone is no group";
}

TEST_F(GroupKeeperTest, LeavesThoseAloneThatAreSentMoreThanTheGroup) {
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

TEST_F(GroupKeeperTest, LeavesThoseAloneThatNoGoodLinkLeadsTo) {
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

TEST_F(GroupKeeperTest, TakesHostsOfItsOwnOnlyWhereEverythingIsAllowed) {
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

TEST_F(GroupKeeperTest, GathersNobodyWhereMulticastIsOff) {
  restart(Multicast::off);
  readers(3);
  serve();
  EXPECT_EQ(go_on(200ms), 0);
  EXPECT_EQ(why(1), "alone: multicast is off by option");
}

TEST_F(GroupKeeperTest, NamesNobodyElseWhereOneReaderIsAlone) {
  readers(1);
  serve();
  EXPECT_NE(keeper_->sizes(), nullptr) << "somebody may come";
  EXPECT_EQ(why(1), "alone: nobody else could be in a group with it");
}

TEST_F(GroupKeeperTest, GoesOnMeasuringWhateverReadersAskFor) {
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

TEST_F(GroupKeeperTest, LeavesThoseAloneForAMinuteThatHearNothing) {
  readers(3);
  serve();
  go_on(200ms);
  ASSERT_EQ(members(), 3U);
  const auto send_and_tend = [&] {
    for (const auto& group : groups_) {
      const std::uint64_t ordinal = group->next_ordinal(now_);
      for (std::size_t i = 0; i < 3; ++i) group->placed(i, ordinal, ordinal);
      for (std::size_t i = 0; i < 2; ++i)
        group->hear({7, group->name().number, group->farewell(i).member, ordinal}, now_);
    }
    keeper_->tend(now_);
  };
  const auto offered = now_;
  for (; !keeper_->replan(now_) && now_ < offered + 1min; now_ += 10ms) send_and_tend();
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

TEST_F(GroupKeeperTest, TakesAGroupBackASecondAfterItWasOver) {
  readers(2);
  serve();
  go_on(200ms);
  ASSERT_EQ(members(), 2U);
  const std::uint32_t number = groups_[0]->name().number;
  readers(1);
  serve();
  go_on(110ms);
  ASSERT_EQ(members(), 3U);
  EXPECT_GT(groups_[0]->name().number, number) << "others make another group";
  const auto taken_back = [&] {
    std::size_t count = 0;
    for (const auto& datagram : connections_.sent()) {
      const auto offer = parse_group_offer(datagram);
      count += offer && offer->group == number && offer->address == 0 ? 1 : 0;
    }
    return count;
  };
  const auto over = now_ - 10ms;
  keeper_->tend(over + 900ms);
  EXPECT_EQ(taken_back(), 0U) << "something of it may be under way";
  keeper_->tend(over + 1010ms);
  EXPECT_EQ(taken_back(), 2U);
  keeper_->tend(over + 2s);
  EXPECT_EQ(taken_back(), 2U) << "once";
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

TEST_F(GroupKeeperTest, MakesAnotherGroupWhereOneIsBroken) {
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

TEST_F(GroupKeeperTest, SendsDatagramsThatTheNarrowestWayTakesAndTheSmallestBufferHolds) {
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

TEST_F(GroupKeeperTest, HasAddressesOfItsRangeOnly) {
  for (std::uint32_t writer = 1; writer <= 50; ++writer) {
    restart(Multicast::automatic, writer * 2654435761U);
    routes_.clear();
    reader(first_link + 10);
    reader(first_link + 11);
    serve();
    go_on(150ms);
    ASSERT_EQ(groups_.size(), 1U);
    const std::uint32_t address = groups_[0]->name().address;
    ASSERT_GE(address, 0xefff1000U);  // 239.255.16.0
    ASSERT_LE(address, 0xefffefffU);  // 239.255.239.255
  }
}

TEST_F(GroupKeeperTest, GathersNobodyAroundATypeWithSoManyFieldsThatMasksAreNotSent) {
  for (const std::size_t leaves : {2048U, 2049U}) {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < leaves; ++i) names.push_back("m" + std::to_string(i));
    std::vector<StructType::Member> members;
    for (const std::string& name : names)
      members.push_back({.name = name, .kind = StructType::Member::Kind::uint8});
    const StructType type("test::Large", members);
    keeper_ = std::make_unique<GroupKeeper>(setup(type, Multicast::automatic, 7));
    routes_.clear();
    for (std::uint32_t host = 10; host < 12; ++host) reader(first_link + host).mask = FieldMask::full(leaves);
    serve();
    EXPECT_EQ(why(1), leaves > 2048 ? "alone: its type has too many fields" : restless);
    keeper_ = nullptr;
  }
}

}  // namespace
}  // namespace sft::udp
