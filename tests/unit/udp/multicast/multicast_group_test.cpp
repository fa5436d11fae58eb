#include "udp_transport/multicast/multicast_group.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "tests/support/heap_bytes.h"
#include "tests/unit/udp/connections.h"
#include "tests/unit/udp/messages.h"
#include "udp_transport/flow/destination_directory.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;
using test::Image;

constexpr std::uint32_t group_writer = 7, group_number = 2;

/// The group has four members. Members 0 to 2 are reliable, and their channels have carried samples before.
/// Member 3 is best-effort.
class MulticastGroupTest : public testing::Test {
 protected:
  void SetUp() override {
    std::vector<MulticastGroup::Member> members;
    for (std::uint16_t i = 0; i < 4; ++i) {
      const auto to = directory_.find({.ip = core::loopback_ipv4, .port = static_cast<std::uint16_t>(i + 1)});
      auto channel = i == 3 ? nullptr : std::make_shared<Channel>(group_writer, i + 1U, to, tally_, 9);
      for (std::uint16_t n = 0; channel != nullptr && n < i; ++n) keep(*channel, job(8), false);
      members.push_back({std::make_shared<Lane>(to, 4, tally_), std::move(channel)});
    }
    const auto to = directory_.find({.ip = core::IpAddress(private_groups + 1), .port = group_port});
    group = MulticastGroup::make({group_writer, group_number, private_groups + 1},
                                 std::make_shared<Lane>(to, 4, tally_), std::move(members), 9);
  }

  JobHandle job(std::size_t bytes) {
    const FieldMask all = test::fields<Image>("*");
    const Image image = test::make_image(bytes);
    core::SampleHandle sample = memory_->take(test::sample_bytes(image, all));
    test::fill(*sample, image, all, group_writer, 1);
    JobHandle made = jobs_->take();
    const TypeSupport& type = test::type_support<Image>();
    made->projection.project(core::state_of(*sample, type.index_slots()), type.type(), all);
    made->mask = std::make_shared<WireMask>(WireMask{5, all.hash(), {}});
    made->first.label = {group_writer, 1, 5};
    made->first.total = static_cast<std::uint32_t>(made->projection.bytes());
    made->sample = std::move(sample);
    return made;
  }
  static std::uint64_t keep(Channel& channel, const JobHandle& job, bool elsewhere) {
    return channel.post_shared(job, job->first, elsewhere).kept.ordinal;
  }
  /// Makes a job for the group, and notes its ordinals in the members' channels. The job is not sent yet.
  JobHandle place(std::size_t bytes = 8) {
    const JobHandle sent = job(bytes);
    const std::uint64_t ordinal = group->next_ordinal(now);
    if (first_sent == 0) first_sent = ordinal;
    for (std::size_t i = 0; i < 3; ++i)
      group->placed(i, ordinal, keep(*group->members()[i].channel, sent, group->hears(i)));
    sent->first.group = {group_number, 0, ordinal};
    return sent;
  }
  /// Sends a sample to the group. Returns the sample's ordinal in the group.
  std::uint64_t send(std::size_t bytes = 8) {
    const JobHandle sent = place(bytes);
    group->departed(*sent, false);
    return sent->first.group.ordinal;
  }
  std::uint32_t name_of(std::size_t member) const { return group->farewell(member).member; }
  void report(std::size_t member, std::uint64_t heard) {
    group->hear({group_writer, group_number, name_of(member), heard}, now);
  }
  void all_report() {
    const std::uint64_t ordinal = send();
    for (std::uint32_t i = 0; i < 4; ++i) report(i, ordinal);
  }
  /// Makes a member request the sample again. Returns the number of parts that have to be sent to this member
  /// alone.
  std::size_t ask(std::size_t member, std::uint64_t ordinal) {
    Ack ack{.writer = group_writer, .channel = static_cast<std::uint32_t>(member + 1), .next = 1};
    ack.missing[ack.missing_count++] = {static_cast<std::uint32_t>(ordinal - first_sent + 1 + member), 0, 0};
    reported += group->take_over_repairs(member, ack, now) == Wake::schedule ? 1 : 0;
    return ack.missing_count;
  }
  /// Takes all jobs that wait to be sent to the group again. Returns their number.
  std::size_t sent_again() {
    std::size_t count = 0;
    while (group->lane()->next() != nullptr) ++count;
    return count;
  }

  GroupMembership::Time now{1h};
  std::uint64_t first_sent = 0;  ///< the ordinal of the first sample in the group
  std::shared_ptr<MulticastGroup> group;
  int reported = 0;

 private:
  std::shared_ptr<core::BufferPool> memory_ = core::BufferPool::make(std::size_t{64} << 20);
  std::shared_ptr<JobPool> jobs_ = JobPool::make();
  std::shared_ptr<WriterTally> tally_ = std::make_shared<WriterTally>();
  test::Connections connections_;
  DestinationDirectory directory_{DestinationLimits{}, connections_.connect()};
};

TEST_F(MulticastGroupTest, IsOfferedOnceItIsKnownHowFarTheChannelIsAhead) {
  auto offers = group->offers(now);
  ASSERT_EQ(offers.size(), 1U) << "of the one without a channel";
  EXPECT_EQ(offers[0].member, 3U);
  send();
  offers = group->offers(now);
  ASSERT_EQ(offers.size(), 3U);
  for (std::uint32_t i = 0; i < 3; ++i) {
    const GroupOffer offer{.writer = group_writer,
                           .group = group_number,
                           .member = name_of(i),
                           .port = 9,
                           .address = private_groups + 1,
                           .channel = i + 1,
                           .ahead = static_cast<std::int64_t>(i + 1 - first_sent)};
    EXPECT_EQ(offers[i].offer, offer);
  }
}

TEST_F(MulticastGroupTest, LeavesNothingInItsRegistry) {
  GroupRegistry registry;
  const std::shared_ptr<Lane> lane = group->lane();
  std::uint32_t number = 0;
  const auto come_and_go = [&] {
    registry.add(
        MulticastGroup::make({group_writer, ++number, private_groups + 1}, lane, group->members(), 9));
  };
  EXPECT_LT(sft::test::bytes_left_by(come_and_go), sft::test::nothing_left);
}

TEST_F(MulticastGroupTest, AcceptsNoReportOfWhatWasNotSent) {
  const std::uint64_t sent = send();
  for (const std::uint64_t heard : {std::uint64_t{1}, sent - 2, sent + 1}) {
    report(0, heard);
    EXPECT_FALSE(group->hears(0)) << heard;
  }
  for (const std::uint32_t name : {0U, 1U, 4U, name_of(1) - 1, name_of(0) + 1, name_of(0) ^ 0x10000}) {
    group->hear({group_writer, group_number, name, sent}, now);
    EXPECT_FALSE(group->hears(0) || group->hears(1)) << "a report of one that was altered is nobody else's";
  }
  report(0, sent);
  EXPECT_TRUE(group->hears(0));
  EXPECT_FALSE(group->hears(1));
}

/// The group is offered to best-effort members at once, so that the first sample need not be sent to each of
/// them separately.
TEST_F(MulticastGroupTest, IsHeardBeforeItsFirstSample) {
  EXPECT_EQ(group->next_probe(), GroupMembership::Time::max()) << "nobody was offered the group";
  ASSERT_EQ(group->offers(now).size(), 1U);
  EXPECT_FALSE(group->probe(now)) << "the member has not joined yet";
  ASSERT_EQ(group->next_probe(), now + ProbeSchedule::first_pause);
  now = group->next_probe();
  const auto probe = group->probe(now);
  ASSERT_TRUE(probe);
  EXPECT_EQ(probe->writer, group_writer);
  EXPECT_EQ(probe->group, group_number);
  report(3, probe->ordinal);
  EXPECT_TRUE(group->hears(3));
  EXPECT_EQ(send(), probe->ordinal + 1);
}

TEST_F(MulticastGroupTest, SendsProbesUntilAllHaveReportedOrItHasSentFive) {
  const std::uint64_t sent = send();
  ASSERT_EQ(group->offers(now).size(), 4U);
  std::vector<std::chrono::milliseconds> after;
  const auto begin = now;
  while (group->next_probe() != GroupMembership::Time::max()) {
    now = group->next_probe();
    const auto probe = group->probe(now);
    ASSERT_TRUE(probe);
    EXPECT_EQ(probe->ordinal, sent) << "a probe takes no place";
    after.push_back(std::chrono::floor<std::chrono::milliseconds>(now - begin));
  }
  EXPECT_EQ(after, (std::vector<std::chrono::milliseconds>{2ms, 6ms, 14ms, 30ms, 62ms}));
  send();
  now += 1s;
  ASSERT_EQ(group->offers(now).size(), 4U);
  all_report();
  now = group->next_probe();
  EXPECT_FALSE(group->probe(now)) << "nobody needs it";
  EXPECT_EQ(group->next_probe(), GroupMembership::Time::max());
}

TEST_F(MulticastGroupTest, IsOverWhenSomethingElseTookAPlaceInAChannel) {
  all_report();
  keep(*group->members()[1].channel, job(8), false);
  EXPECT_FALSE(group->broken());
  send();
  EXPECT_TRUE(group->broken());
  for (std::size_t i = 0; i < 4; ++i) EXPECT_FALSE(group->hears(i)) << i;
  EXPECT_TRUE(group->members()[1].channel->sent_elsewhere(4)) << "and can be asked for";
  now += 1min;
  EXPECT_TRUE(group->offers(now).empty());
}

TEST_F(MulticastGroupTest, TellsOfWhatLeavesOnceTheSendingThreadHasLooked) {
  all_report();
  Channel& channel = *group->members()[0].channel;
  const auto piece = channel.next(ResendWindow::Size::small).value();
  static_cast<void>(channel.finished(piece, std::chrono::steady_clock::now()));
  ASSERT_TRUE(channel.look_after().heartbeat);
  static_cast<void>(channel.hear({.writer = group_writer, .channel = 1, .next = 2}));
  ASSERT_TRUE(channel.look_after().at_rest);
  const JobHandle sent = place();
  EXPECT_EQ(channel.look_after().next_look, Channel::Time::max());
  EXPECT_EQ(group->note_departed(*sent, false), Wake::look);
  EXPECT_EQ(group->note_departed(*sent, false), Wake::none) << "that was told";
}

TEST_F(MulticastGroupTest, IsThereAsLongAsSomethingWaitsInItsLane) {
  all_report();
  const std::shared_ptr<Channel> channel = group->members()[0].channel;
  const std::shared_ptr<Lane> lane = MulticastGroup::lane_of(group);
  lane->post(place());
  group = nullptr;
  ASSERT_NE(lane->next(), nullptr);
  EXPECT_FALSE(channel->sent_elsewhere(2));
  EXPECT_EQ(lane->next(), nullptr);
  EXPECT_TRUE(channel->sent_elsewhere(2));
}

TEST_F(MulticastGroupTest, AnswersAloneWhoDoesNotHearIt) {
  const std::uint64_t lost = send();
  report(0, lost);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(ask(i, lost), 1U);
}

TEST_F(MulticastGroupTest, SendsAgainToAllWhatASecondOneAsksForAndAnswersOthersNoMore) {
  all_report();
  const std::uint64_t lost = send(), other = send();
  EXPECT_EQ(ask(0, lost), 1U) << "the first is answered alone";
  EXPECT_EQ(ask(0, lost), 1U) << "once more";
  EXPECT_EQ(ask(1, other), 1U);
  EXPECT_EQ(reported, 0);
  EXPECT_EQ(ask(1, lost), 0U);
  EXPECT_EQ(ask(2, lost), 0U);
  EXPECT_EQ(reported, 1);
  EXPECT_EQ(sent_again(), 1U);
  EXPECT_EQ(ask(1, lost), 1U) << "it lost that as well";
  now += 100ms;
  EXPECT_EQ(ask(2, lost), 1U) << "that did not help it";
}

TEST_F(MulticastGroupTest, TakesWhatIsAskedForWithinATenthOfASecondForLostTogether) {
  all_report();
  const std::uint64_t first = send(), second = send();
  EXPECT_EQ(ask(0, first), 1U);
  now += 99ms;
  EXPECT_EQ(ask(1, first), 0U);
  EXPECT_EQ(ask(0, second), 1U);
  now += 100ms;
  EXPECT_EQ(ask(1, second), 1U);
  EXPECT_EQ(sent_again(), 1U);
}

/// The sample has a different ordinal in each channel, because the channels have carried different numbers
/// of samples.
TEST_F(MulticastGroupTest, AnswersEachAloneOfASampleThatAnotherGroupWasSent) {
  all_report();
  JobHandle sent = job(8);
  const std::uint64_t ordinal = group->next_ordinal(now);
  for (std::size_t i = 0; i < 3; ++i)
    group->placed(i, ordinal, keep(*group->members()[i].channel, sent, group->hears(i)));
  sent->first.group = {group_number + 1, 0, ordinal};
  group->departed(*sent, false);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(ask(i, ordinal), 1U);
  EXPECT_EQ(sent_again(), 0U);
}

TEST_F(MulticastGroupTest, AnswersEachAloneOfALargeSample) {
  all_report();
  const std::uint64_t lost = send(20'000);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(ask(i, lost), 1U);
  EXPECT_EQ(sent_again(), 0U);
}

TEST_F(MulticastGroupTest, SamplesThatItLosesAreLostForMembersThatHearItAndDoNotAskForThemAgain) {
  const auto lost = [&](std::size_t member) {
    const core::DeliveryMeter::Reading counted =
        core::DeliveryMeter{.losses = group->members()[member].lane->losses()}.read();
    EXPECT_EQ(counted.lost_bytes, counted.lost * place()->first.total);
    return counted.lost;
  };
  group->departed(*place(), true);
  EXPECT_EQ(lost(3), 0U) << "this member gets the sample alone";
  all_report();
  group->departed(*place(), false);
  EXPECT_EQ(lost(3), 0U);
  for (std::uint64_t count = 1; count <= 3; ++count) {
    group->departed(*place(), true);
    EXPECT_EQ(lost(3), count);
    for (std::size_t reliable = 0; reliable < 3; ++reliable) EXPECT_EQ(lost(reliable), 0U);
  }
}

}  // namespace
}  // namespace sft::udp
