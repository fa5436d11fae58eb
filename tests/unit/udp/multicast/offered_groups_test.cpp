#include "udp_transport/multicast/offered_groups.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "udp_transport/multicast/group_membership.h"

#include "tests/unit/udp/start.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;
using Time = OfferedGroups::Time;

constexpr std::uint32_t offered_address = private_groups | 0x1001;
const SocketAddress writer_at{0x0a000001, 1};

class OfferedGroupsTest : public testing::Test {
 protected:
  /// Offers a group. Returns true if the process has to join the group again.
  bool offer(std::uint32_t group, std::uint32_t channel = 0, std::int64_t ahead = 0, Time now = test_start) {
    return groups_.hear({.writer = 1,
                         .group = group,
                         .member = 3,
                         .port = 77,
                         .address = offered_address,
                         .channel = channel,
                         .ahead = ahead},
                        writer_at, now);
  }
  bool offer_at(Time now) { return offer(1, 0, 0, now); }
  bool place(std::uint32_t group, std::uint64_t ordinal, Time now = test_start,
             const ChannelMonitor* channels = nullptr) {
    first_ = {};
    first_.flags = group_follows;
    first_.group = {group, 0, ordinal};
    return groups_.place(first_, now, channels);
  }
  std::vector<GroupReport> reports() {
    std::vector<GroupReport> sent;
    groups_.report([&](const SocketAddress& to, const GroupReport& report) {
      EXPECT_EQ(to, (SocketAddress{writer_at.ip, 77}));
      sent.push_back(report);
    });
    return sent;
  }

  OfferedGroups groups_;
  FirstHeader first_;
};

TEST_F(OfferedGroupsTest, IgnoreWhatIsOfAGroupThatWasNotOffered) {
  EXPECT_FALSE(place(1, 1));
  offer(2);
  EXPECT_FALSE(place(1, 1));
  EXPECT_TRUE(reports().empty());
}

TEST_F(OfferedGroupsTest, ReportAProbeLikeASample) {
  groups_.hear(GroupProbe{1, 1, 70}, test_start);
  EXPECT_TRUE(reports().empty()) << "the group was not offered";
  offer(1, 9, -60);
  EXPECT_FALSE(groups_.were_heard());
  groups_.hear(GroupProbe{1, 1, 70}, test_start);
  EXPECT_EQ(reports(), (std::vector<GroupReport>{{1, 1, 3, 70}}));
  EXPECT_TRUE(groups_.were_heard());
  EXPECT_TRUE(place(1, 71));
  EXPECT_EQ(first_.channel.ordinal, 11U);
  EXPECT_TRUE(reports().empty()) << "the group was reported a moment ago";
}

TEST_F(OfferedGroupsTest, AreToBeOfferedAgainWhereWhatComesHasNoPlace) {
  offer(1, 9, 5);
  for (std::uint64_t n = 1; n <= 7; ++n) {
    EXPECT_TRUE(place(1, n));
    groups_.note(1, true);
  }
  groups_.note(1, false);
  EXPECT_EQ(reports(), (std::vector<GroupReport>{{1, 1, 3, 7}})) << "not in a row";
  for (std::uint64_t n = 1; n <= 7; ++n) groups_.note(1, true);
  EXPECT_TRUE(reports().empty()) << "not in a row";
  groups_.note(1, true);
  EXPECT_EQ(reports(), (std::vector<GroupReport>{{1, 1, 3, 0}}));
  for (std::uint64_t n = 1; n <= 7; ++n) groups_.note(1, true);
  EXPECT_TRUE(reports().empty()) << "it is asked for not more often than for each eight";
  groups_.note(1, true);
  EXPECT_EQ(reports(), (std::vector<GroupReport>{{1, 1, 3, 0}}));
  EXPECT_TRUE(place(1, 8, test_start + 1h));
  EXPECT_TRUE(reports().empty()) << "who reports would not be offered it again";
  offer(1, 9, 6);
  offer(1, 9, 6);
  EXPECT_TRUE(place(1, 9, test_start + 1h));
  EXPECT_EQ(first_.channel.ordinal, 15U);
  EXPECT_EQ(reports(), (std::vector<GroupReport>{{1, 1, 3, 9}}));
}

TEST_F(OfferedGroupsTest, AreToBeOfferedAgainAtOnceWhereOneThatIsInUseIsReplacedOrTakenBack) {
  const GroupReport offer_it_again{1, 1, 3, 0};
  const auto use = [&] {
    offer(1, 9, 5);
    offer(1, 9, 5);  // a second offer, since there may be two groups
    ASSERT_TRUE(place(1, 1));
    reports();
  };
  use();
  offer(1, 8, 5);
  EXPECT_TRUE(reports().empty()) << "that says one datagram";
  offer(1, 8, 5);
  EXPECT_EQ(reports(), std::vector{offer_it_again});
  use();
  GroupOffer taken_back{.writer = 1, .group = 1, .member = 3, .port = 77};
  groups_.hear(taken_back, writer_at, test_start);
  EXPECT_TRUE(reports().empty());
  groups_.hear(taken_back, writer_at, test_start);
  EXPECT_EQ(reports(), std::vector{offer_it_again});
  use();
  groups_.hear(taken_back, writer_at, test_start + 1s);
  EXPECT_TRUE(reports().empty()) << "its writer has used another one for a while";
}

TEST_F(OfferedGroupsTest, PlaceNothingInAChannelThatIsNotFollowedWhileAnotherIs) {
  ChannelMonitor channels;
  offer(1, 9);
  EXPECT_TRUE(place(1, 1, test_start, &channels)) << "none is known";
  channels.turn(4, 0);
  EXPECT_FALSE(place(1, 2, test_start, &channels));
  channels.turn(9, 0);
  EXPECT_TRUE(place(1, 3, test_start, &channels));
  channels.turn(10, 0);
  EXPECT_FALSE(place(1, 4, test_start, &channels)) << "an offer does not make the reader go back";
}

TEST_F(OfferedGroupsTest, AreToBeOfferedAgainWhereTheirChannelIsNotFollowed) {
  ChannelMonitor channels;
  channels.turn(4, 0);
  offer(1, 9);
  for (std::uint64_t n = 1; n <= 7; ++n) EXPECT_FALSE(place(1, n, test_start, &channels));
  EXPECT_TRUE(reports().empty()) << "the channel may become known yet";
  EXPECT_FALSE(place(1, 8, test_start, &channels));
  EXPECT_EQ(reports(), (std::vector<GroupReport>{{1, 1, 3, 0}}));
}

TEST_F(OfferedGroupsTest, ThatWereReplacedWithoutBeingHeardAreNotAskedForAgain) {
  offer(1, 9, 5);
  offer(1, 8, 5);
  offer(1, 8, 5);
  EXPECT_TRUE(reports().empty());
}

TEST_F(OfferedGroupsTest, OfWhichAnotherOfferSaysOtherwiseAreNotReportedUntilOneIsConfirmed) {
  offer(1, 9, 5);
  offer(1, 8, 5);
  EXPECT_TRUE(place(1, 1));
  EXPECT_TRUE(reports().empty()) << "the writer offers the true one again";
  offer(1, 9, 5);
  EXPECT_TRUE(place(1, 2));
  EXPECT_EQ(reports(), (std::vector<GroupReport>{{1, 1, 3, 2}}));
}

TEST_F(OfferedGroupsTest, AreAskedForAgainFourTimesAtMostBetweenTwoReports) {
  for (std::uint64_t n = 1; n <= 10; ++n) {
    for (int again = 0; again < 2; ++again) offer(1, 9, static_cast<std::int64_t>(n));
    ASSERT_TRUE(place(1, n));
  }
  const std::vector<GroupReport> sent = reports();
  EXPECT_EQ(std::ranges::count(sent, GroupReport{1, 1, 3, 0}), 4);
}

TEST_F(OfferedGroupsTest, ReportTheLastOrdinalWhateverComesLate) {
  offer(1);
  place(1, 7);
  place(1, 5);
  EXPECT_EQ(reports(), (std::vector<GroupReport>{{1, 1, 3, 7}}));
}

TEST_F(OfferedGroupsTest, ReportToWhereTheLastOfferSays) {
  GroupOffer again{.writer = 1, .group = 1, .member = 3, .port = 78, .address = offered_address};
  offer(1);
  groups_.hear(again, writer_at, test_start);
  groups_.hear(again, writer_at, test_start);
  place(1, 1);
  std::vector<SocketAddress> notified;
  groups_.report([&](const SocketAddress& to, const GroupReport&) { notified.push_back(to); });
  EXPECT_EQ(notified, (std::vector<SocketAddress>{{writer_at.ip, 78}}));
}

TEST_F(OfferedGroupsTest, MakeNoRoomForOthersWhileTheyAreHeard) {
  for (std::uint32_t group = 1; group <= 4; ++group) {
    offer(group);
    ASSERT_TRUE(place(group, 1));
  }
  offer(5);
  EXPECT_FALSE(place(5, 1));
  for (std::uint32_t group = 2; group <= 4; ++group) ASSERT_TRUE(place(group, 2, test_start + 500ms));
  offer(5, 0, 0, test_start + 500ms);
  EXPECT_TRUE(place(5, 1, test_start + 500ms));
  EXPECT_FALSE(place(1, 2, test_start + 500ms));
}

/// Readers come one after another, and the writer makes a new group after each of them.
TEST_F(OfferedGroupsTest, MakeRoomOnceLaterOnesAreHeard) {
  Time now = test_start;
  constexpr std::uint32_t numbers_turn_over = UINT32_MAX - 3;
  for (std::uint32_t change = 0; change < 20; ++change, now += 50ms) {
    offer(numbers_turn_over + change, 0, 0, now);
    EXPECT_TRUE(place(numbers_turn_over + change, 1, now + 20ms)) << "change " << change;
  }
}

TEST_F(OfferedGroupsTest, StayWhileSomethingOfThemMayBeUnderWayAlthoughALaterOneIsHeard) {
  for (std::uint32_t group = 1; group <= 4; ++group) {
    offer(group);
    place(group, 1, test_start + std::chrono::milliseconds(group));
  }
  offer(5, 0, 0, test_start + 100ms);
  EXPECT_FALSE(place(5, 1, test_start + 100ms));
  EXPECT_TRUE(place(1, 2, test_start + 100ms));
  offer(5, 0, 0, test_start + 102ms);
  EXPECT_TRUE(place(5, 1, test_start + 102ms));
  EXPECT_FALSE(place(2, 2, test_start + 102ms)) << "it was the oldest one then";
  EXPECT_TRUE(place(1, 3, test_start + 102ms));
}

TEST_F(OfferedGroupsTest, MakeNoRoomForOthersBecauseEarlierOnesAreHeard) {
  for (std::uint32_t group = 1; group <= 4; ++group) offer(group);
  place(4, 1);
  for (std::uint32_t group = 1; group <= 3; ++group) place(group, 1, test_start + 100ms);
  offer(5, 0, 0, test_start + 200ms);
  EXPECT_FALSE(place(5, 1, test_start + 200ms));
  EXPECT_TRUE(place(4, 2, test_start + 200ms));
}

/// An attacker forges offers of groups with later numbers, and sends to these groups.
TEST_F(OfferedGroupsTest, AreToBeOfferedAgainAtOnceWhereForgedOnesThatAreHeardTookTheirRoom) {
  offer(1);
  place(1, 1);
  for (std::uint32_t forged = 2; forged <= 4; ++forged) {
    offer(forged);
    place(forged, 1, test_start + 50ms);
  }
  reports();
  offer(5, 0, 0, test_start + 100ms);
  EXPECT_FALSE(place(1, 2, test_start + 100ms));
  EXPECT_EQ(reports(), (std::vector<GroupReport>{{1, 1, 3, 0}}));
}

TEST_F(OfferedGroupsTest, EndAsThoseBeforeAlsoWhereTheirNumbersTurnOver) {
  offer(0xFFFF'FFFF);
  offer(1);
  groups_.hear({.writer = 1, .group = 0xFFFF'FFFF, .member = 3, .port = 77}, writer_at, test_start);
  EXPECT_FALSE(place(0xFFFF'FFFF, 1));
  EXPECT_TRUE(place(1, 1));
  offer(0xFFFF'FFFE);
  groups_.hear({.writer = 1, .group = 1, .member = 3, .port = 77}, writer_at, test_start + 1h);
  EXPECT_TRUE(groups_.empty());
}

TEST_F(OfferedGroupsTest, GiveNoPlaceBeforeOrBehindAllThatAChannelCanHave) {
  offer(1, 9, static_cast<std::int64_t>(ordinal_max) - 5);
  EXPECT_TRUE(place(1, 5));
  EXPECT_FALSE(place(1, 6));
  offer(2, 9, -5);
  EXPECT_FALSE(place(2, 5));
  EXPECT_TRUE(place(2, 6));
}

TEST_F(OfferedGroupsTest, GiveASampleItsPlaceInTheChannel) {
  offer(1, 9, 40);
  ASSERT_TRUE(place(1, 2));
  EXPECT_EQ(first_.flags, group_follows | channel_follows);
  EXPECT_EQ(first_.channel, (ChannelMark{9, 0, 42}));
  offer(2, 9, -40);
  EXPECT_FALSE(place(2, 40)) << "there is no ordinal 0";
  ASSERT_TRUE(place(2, 41));
  EXPECT_EQ(first_.channel.ordinal, 1U);
  ASSERT_TRUE(place(1, 3)) << "something of the group before is under way";
  EXPECT_EQ(first_.channel.ordinal, 43U);
}

TEST_F(OfferedGroupsTest, LeaveASampleAloneThatIsSentByBestEffort) {
  offer(1);
  ASSERT_TRUE(place(1, 2));
  EXPECT_EQ(first_.flags, group_follows);
}

TEST_F(OfferedGroupsTest, ReportTheFirstSampleAtOnceAndThenNowAndAgain) {
  offer(1);
  place(1, 5);
  EXPECT_EQ(reports(), (std::vector<GroupReport>{{1, 1, 3, 5}}));
  place(1, 6, test_start + group_report_pause - 1ms);
  EXPECT_TRUE(reports().empty());
  place(1, 7, test_start + group_report_pause);
  EXPECT_EQ(reports(), (std::vector<GroupReport>{{1, 1, 3, 7}}));
  offer(1);  // repeats the offer, since the report was lost
  place(1, 8, test_start + group_report_pause);
  EXPECT_EQ(reports(), (std::vector<GroupReport>{{1, 1, 3, 8}}));
}

TEST_F(OfferedGroupsTest, EndWithAnOfferWithoutAnAddressAsDoThoseBefore) {
  offer(1);
  offer(2);
  offer(3);
  EXPECT_FALSE(groups_.hear({.writer = 1, .group = 2, .member = 3, .port = 77}, writer_at, test_start + 1h));
  EXPECT_FALSE(place(1, 1));
  EXPECT_FALSE(place(2, 1));
  EXPECT_TRUE(place(3, 1));
  std::vector<std::uint32_t> joined;
  groups_.addresses(joined);
  EXPECT_EQ(joined, std::vector<std::uint32_t>{offered_address});
}

TEST_F(OfferedGroupsTest, AreJoinedAnewIfNothingOfThemComesButNotForEachOffer) {
  EXPECT_FALSE(offer_at(test_start));
  EXPECT_FALSE(offer_at(test_start + 249ms)) << "a switch may learn of it yet";
  EXPECT_TRUE(offer_at(test_start + 250ms));
  EXPECT_FALSE(offer_at(test_start + 499ms)) << "since it was joined anew";
  EXPECT_TRUE(offer_at(test_start + 500ms));
}

TEST_F(OfferedGroupsTest, AreNotJoinedAnewWhileTheyAreHeard) {
  EXPECT_FALSE(offer_at(test_start));
  place(1, 1, test_start + 1h);
  EXPECT_FALSE(offer_at(test_start + 1h + 249ms)) << "the report got lost";
  EXPECT_TRUE(offer_at(test_start + 1h + 250ms));
}

TEST_F(OfferedGroupsTest, AreNeverMany) {
  for (std::uint32_t group = 1; group <= 1000; ++group) offer(group);
  std::vector<std::uint32_t> joined;
  groups_.addresses(joined);
  EXPECT_LE(joined.size(), 4U);
  EXPECT_TRUE(place(1000, 1));
}

TEST(GroupMembership, IsOfferedUntilAReportComesButNotWhileNothingIsSent) {
  GroupMembership member;
  EXPECT_TRUE(member.offer_due(test_start));
  EXPECT_FALSE(member.offer_due(test_start + 10s)) << "it could not have heard anything";
  member.sent(test_start + 10s);
  EXPECT_TRUE(member.offer_due(test_start + 10s));
  EXPECT_FALSE(member.hears());
  member.sent(test_start + 20s);
  member.reported(1, test_start + 20s);
  EXPECT_TRUE(member.hears());
  EXPECT_FALSE(member.offer_due(test_start + 20s));
}

TEST(GroupMembership, EndsWhenSamplesThatAreSentAreNotReportedAnyMore) {
  GroupMembership member;
  member.reported(1, test_start);
  member.look(test_start + 1h);
  EXPECT_TRUE(member.hears()) << "nothing was sent";
  member.sent(test_start + 1h);
  member.look(test_start + 1h + 400ms);
  EXPECT_TRUE(member.hears());
  member.look(test_start + 1h + 500ms);
  EXPECT_FALSE(member.hears());
  EXPECT_TRUE(member.offer_due(test_start + 1h + 500ms));
  member.reported(1, test_start + 2h);
  EXPECT_TRUE(member.hears());
}

TEST(GroupMembership, IsOfferedAgainAtOnceWhenItRefusesTheOffer) {
  GroupMembership member;
  member.refused(0, test_start);
  EXPECT_TRUE(member.offer_due(test_start));
  EXPECT_FALSE(member.offer_due(test_start)) << "it is offered anyway";
  member.reported(1, test_start);
  EXPECT_FALSE(member.offer_due(test_start + 1s));
  member.refused(7, test_start + 1s);
  EXPECT_FALSE(member.hears());
  EXPECT_TRUE(member.offer_due(test_start + 1s));
  member.reported(7, test_start + 1s);
  EXPECT_FALSE(member.hears()) << "that is an earlier report once more, maybe by a forger";
  member.reported(8, test_start + 1s);
  EXPECT_TRUE(member.hears());
}

TEST(GroupMembership, StaysWhileReportsComeEveryNowAndThen) {
  GroupMembership member;
  for (Time now = test_start; now < test_start + 10s; now += 10ms) {
    if ((now - test_start) % 1000ms == 0ms) member.reported(1, now);
    member.sent(now);
    member.look(now);
    ASSERT_TRUE(member.hears());
  }
}

}  // namespace
}  // namespace sft::udp
