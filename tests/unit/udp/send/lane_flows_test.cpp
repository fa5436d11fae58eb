#include "udp_transport/send/lane_flows.h"

#include <gtest/gtest.h>

#include <memory>
#include <span>
#include <thread>
#include <utility>
#include <vector>

#include "tests/unit/udp/send/sending.h"

namespace sft::udp {
namespace {

using test::large_bytes;
using test::small_bytes;

class LaneFlowsTest : public testing::Test, protected test::Sending {
 protected:
  void serve_small() {
    flows.send_small();
    flows.forget_idle();
  }

  LaneFlows flows{sender, scheduled, round};
};

TEST_F(LaneFlowsTest, SendsTheJobsOfALaneUntilItIsIdle) {
  const auto one = lane();
  for (int i = 0; i < 3; ++i) one->post(job(small_bytes));
  flows.add(one);
  for (int rounds = 0; rounds < 3; ++rounds) {
    EXPECT_EQ(flows.count(), 1U);
    EXPECT_FALSE(one->idle());
    serve_small();
  }
  EXPECT_EQ(connections.sent().size(), 3U);
  EXPECT_EQ(flows.count(), 0U);
  EXPECT_TRUE(one->idle());
}

TEST_F(LaneFlowsTest, SendsLargeJobsOnlyInTheirTurn) {
  const auto one = lane();
  one->post(job(large_bytes));
  flows.add(one);
  serve_small();
  EXPECT_EQ(bytes_left(), 0U);
  flows.send_large(0);
  EXPECT_GT(bytes_left(), large_bytes);
  EXPECT_EQ(one->behind(), to->window().position()) << "later samples do not overtake it";
}

TEST_F(LaneFlowsTest, LetsLargeSamplesOfAWriterGoToADestinationOneAfterAnother) {
  const auto one = lane(), other = lane();
  for (const auto& each : {one, other}) {
    each->post(job(large_bytes));
    flows.add(each);
  }
  serve_small();
  connections.take_batches(1);
  flows.send_large(0);
  connections.take_batches(SIZE_MAX);
  const std::size_t begun = bytes_left();
  EXPECT_GT(begun, 0U);
  flows.send_large(1);
  EXPECT_EQ(bytes_left(), begun) << "the first sample is under way";
  flows.send_large(0);
  EXPECT_GT(bytes_left(), large_bytes);
  flows.send_large(1);
  EXPECT_GT(bytes_left(), 2 * large_bytes);
}

/// While a reader changes its mask, or joins a group that does not reach it yet, one sample is in the lane of
/// the former mask, and the next sample in the lane of the new one.
TEST_F(LaneFlowsTest, SendTheOldestLargeSampleFirstWhateverItsMaskIs) {
  const auto before = lane(), after = lane();
  before->post(job(large_bytes));
  after->post(job(large_bytes));
  flows.add(after);
  flows.add(before);
  serve_small();
  flows.send_large(0);
  EXPECT_EQ(bytes_left(), 0U) << "the older sample has not been sent yet";
  flows.send_large(1);
  EXPECT_GT(bytes_left(), large_bytes);
  flows.send_large(0);
  EXPECT_GT(bytes_left(), 2 * large_bytes);
}

TEST_F(LaneFlowsTest, SendLargeSamplesBesideTheHistoryOfALateReader) {
  const auto late = lane(Lane::Start::held), live = lane();
  EXPECT_EQ(late->begin({job(large_bytes)}), Wake::schedule);
  live->post(job(large_bytes));
  flows.add(live);
  flows.add(late);
  serve_small();
  flows.send_large(0);
  EXPECT_GT(bytes_left(), large_bytes) << "it does not wait for the history, although that is older";
}

TEST_F(LaneFlowsTest, LetSmallSamplesPassALargeOneThatIsUnderWayUnderAnotherMask) {
  const auto large = lane(), small = lane();
  large->post(job(large_bytes));
  flows.add(large);
  serve_small();
  connections.take_batches(1);
  flows.send_large(0);
  connections.take_batches(SIZE_MAX);
  const std::size_t begun = bytes_left();
  EXPECT_GT(begun, 0U);
  small->post(job(small_bytes));
  flows.add(small);
  serve_small();
  EXPECT_GT(bytes_left(), begun);
  EXPECT_TRUE(small->idle());
  EXPECT_FALSE(large->idle());
}

/// A listener of a group's lane, which returns the group's members.
struct GroupOf final : LaneListener {
  explicit GroupOf(std::vector<const Destination*> to) : members(std::move(to)) {}
  void departed(const Job&, bool) noexcept override {}
  std::span<const Destination* const> receivers() const noexcept override { return members; }
  std::vector<const Destination*> members;
};

/// Each of these tests has two lanes that may send samples to the same receiver.
class LaneFlowsOfGroupsTest : public LaneFlowsTest {
 protected:
  std::shared_ptr<Destination> destination(std::uint16_t port) {
    const auto found = destinations.find({.ip = 0x7F000001, .port = port});
    found->set_receive_buffer(roomy);
    return found;
  }
  std::shared_ptr<Lane> lane_to_group(std::uint16_t port, std::vector<const Destination*> members) {
    auto result = std::make_shared<Lane>(destination(port), 100, tally);
    groups.push_back(std::make_shared<GroupOf>(std::move(members)));
    result->end().notify(groups.back());
    return result;
  }
  /// Posts a sample to each lane. The sample in `first` is older, but that lane's turn comes last.
  void post(const std::shared_ptr<Lane>& first, const std::shared_ptr<Lane>& then, std::size_t bytes) {
    first->post(job(bytes));
    then->post(job(bytes));
    flows.add(then);
    flows.add(first);
  }
  void expect_order(const std::shared_ptr<Lane>& first, const std::shared_ptr<Lane>& then) {
    post(first, then, large_bytes);
    serve_small();
    flows.send_large(0);
    EXPECT_EQ(bytes_left(), 0U) << "the other one has not begun with the older one";
    flows.send_large(1);
    EXPECT_GT(bytes_left(), large_bytes);
    flows.send_large(0);
    EXPECT_GT(bytes_left(), 2 * large_bytes);
  }

  /// Expects the flow to wait now, and to continue when the sending thread checks again.
  void expect_to_go_on_soon(std::size_t which) {
    flows.send_large(which);
    EXPECT_EQ(bytes_left(), 0U);
    const NextRound::Time at = round.time();
    ASSERT_NE(at, NextRound::Time::max()) << "the sending thread looks again";
    while (NextRound::Time::clock::now() < at) std::this_thread::yield();
    flows.send_large(which);
    EXPECT_GT(bytes_left(), large_bytes);
  }
  void expect_small_to_wait(const std::shared_ptr<Lane>& first, const std::shared_ptr<Lane>& then) {
    first->post(job(large_bytes));
    then->post(job(small_bytes));
    flows.add(then);
    flows.add(first);
    serve_small();
    ASSERT_EQ(flows.count(), 2U);
    EXPECT_EQ(bytes_left(), 0U);
    flows.send_large(1);
    ASSERT_TRUE(first->idle());
    flows.forget_idle();
    serve_small();
    EXPECT_TRUE(then->idle());
  }

  std::vector<std::shared_ptr<GroupOf>> groups;
};

TEST_F(LaneFlowsOfGroupsTest, SendNothingToAMemberBeforeItsFormerGroupHasSentWhatIsOlder) {
  expect_order(lane_to_group(2, {to.get()}), lane());
}

TEST_F(LaneFlowsOfGroupsTest, SendNothingToAGroupBeforeAFormerGroupOfAMemberHasSentWhatIsOlder) {
  const Destination* other = destination(4).get();
  expect_order(lane_to_group(2, {other, to.get()}), lane_to_group(3, {to.get()}));
}

TEST_F(LaneFlowsOfGroupsTest, SendNothingToAGroupBeforeAMemberWasSentWhatIsOlder) {
  expect_order(lane(), lane_to_group(2, {to.get()}));
}

TEST_F(LaneFlowsOfGroupsTest, SendNothingSmallBeforeWhatIsOlder) {
  const auto to_group = lane_to_group(2, {to.get()}), own = lane();
  post(to_group, own, small_bytes);
  connections.take_batches(1);
  serve_small();
  serve_small();
  EXPECT_TRUE(to_group->idle());
  EXPECT_FALSE(own->idle());
  connections.take_batches(SIZE_MAX);
  serve_small();
  EXPECT_EQ(connections.sent().size(), 2U);
}

TEST_F(LaneFlowsOfGroupsTest, WaitForNothingThatIsYounger) {
  const auto own = lane(), to_group = lane_to_group(2, {to.get()});
  post(own, to_group, large_bytes);
  serve_small();
  flows.send_large(1);
  EXPECT_GT(bytes_left(), large_bytes);
}

TEST_F(LaneFlowsOfGroupsTest, WaitForNoGroupWithoutACommonMember) {
  const Destination* other = destination(4).get();
  post(lane_to_group(2, {other}), lane_to_group(3, {to.get()}), large_bytes);
  serve_small();
  flows.send_large(0);
  EXPECT_GT(bytes_left(), large_bytes);
}

/// A blocked member may take 75 ms for each sample. The other members must not wait for the blocked member.
TEST_F(LaneFlowsOfGroupsTest, GoOnWithoutAMemberThatStandsStill) {
  post(lane(), lane_to_group(2, {to.get()}), large_bytes);
  serve_small();
  connections.take_batches(0);
  flows.send_large(1);
  connections.take_batches(SIZE_MAX);
  expect_to_go_on_soon(0);
}

/// A lane that waits for a blocked lane counts as blocked, too.
TEST_F(LaneFlowsOfGroupsTest, GoOnWithoutAMemberOfWhichOneSampleWaitsForAnotherThatStandsStill) {
  const auto shared = lane(), own = lane(), to_group = lane_to_group(2, {to.get()});
  shared->end().set_shared(true);
  for (const auto& each : {shared, own, to_group}) {
    each->post(job(large_bytes));
    flows.add(each);
  }
  serve_small();
  connections.take_batches(0);
  flows.send_large(0);
  flows.send_large(1);
  connections.take_batches(SIZE_MAX);
  expect_to_go_on_soon(2);
}

/// When readers begin or cease to share a copy, their samples are sent through a different lane, although
/// the readers' requests are unchanged.
TEST_F(LaneFlowsOfGroupsTest, SendNothingSmallInASharedCopyBeforeWhatIsOlder) {
  const auto own = lane(), shared = lane();
  shared->end().set_shared(true);
  expect_small_to_wait(own, shared);
}

TEST_F(LaneFlowsOfGroupsTest, SendNothingSmallAloneBeforeASharedCopyThatIsOlder) {
  const auto own = lane(), shared = lane();
  shared->end().set_shared(true);
  expect_small_to_wait(shared, own);
}

TEST_F(LaneFlowsTest, ForgetsALaneThatWasClosed) {
  const auto one = lane();
  one->post(job(large_bytes));
  one->post(job(large_bytes));
  flows.add(one);
  serve_small();
  connections.take_batches(1);
  flows.send_large(0);
  one->close();
  serve_small();
  EXPECT_EQ(flows.count(), 0U);
}

TEST_F(LaneFlowsTest, LetsAJobWaitForRoomInTheSendBuffer) {
  connections.take_batches(0);
  const auto one = lane();
  one->post(job(small_bytes));
  flows.add(one);
  serve_small();
  EXPECT_EQ(flows.count(), 1U);
  EXPECT_NE(round.time(), NextRound::Time::max());
  connections.take_batches(SIZE_MAX);
  serve_small();
  EXPECT_EQ(connections.sent().size(), 1U);
  EXPECT_TRUE(one->idle());
  EXPECT_EQ(tally->dropped, 0U);
}

TEST_F(LaneFlowsTest, HandsTheJobsOfALateReaderToItsChannel) {
  const auto through = channel();
  const auto late = lane(Lane::Start::held, through);
  late->post(job(small_bytes));
  EXPECT_EQ(late->begin({job(small_bytes)}), Wake::schedule);
  flows.add(late);
  serve_small();
  EXPECT_EQ(flows.count(), 0U);
  EXPECT_EQ(connections.sent().size(), 0U) << "the channel sends them";
  EXPECT_TRUE(through->keeps(1));
  EXPECT_TRUE(through->keeps(2));
  ScheduledWork::Taken taken;
  scheduled.take(taken);
  EXPECT_EQ(taken.channels, std::vector{through}) << "the sending thread learns of the channel";
}

TEST_F(LaneFlowsTest, CountsWhatAChannelGivesUpForTheJobsOfALateReaderAsLost) {
  const auto through = channel();
  for (std::size_t i = 0; i < ResendLimits{}.samples; ++i) {
    const JobHandle one = job(small_bytes);
    through->post(one, one->first, false);
  }
  through->end();  // from now on the channel takes jobs however full it is
  const auto late = lane(Lane::Start::held, through);
  (void)late->begin({job(small_bytes), job(small_bytes)});
  flows.add(late);
  serve_small();
  EXPECT_FALSE(through->keeps(2));
  EXPECT_TRUE(through->keeps(3));
  const core::DeliveryMeter meter{.losses = late->losses()};
  EXPECT_EQ(meter.read().lost, 2U);
  EXPECT_EQ(meter.read().lost_bytes, 2 * job(small_bytes)->first.total);
}

}  // namespace
}  // namespace sft::udp
