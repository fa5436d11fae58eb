#include "udp_transport/send/lane_flows.h"

#include <gtest/gtest.h>

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

/// A lane that leads to a group, one member of which hears it.
struct GroupOf final : LaneListener {
  explicit GroupOf(const Destination& to) : member(&to) {}
  void departed(const Job&, bool) noexcept override {}
  bool reaches(const Destination& to) const noexcept override { return &to == member; }
  const Destination* member;
};

TEST_F(LaneFlowsTest, SendsNothingLargeToAMemberBeforeItsFormerGroupHasSentWhatIsOlder) {
  const auto own = lane();
  const auto there = destinations.find({.ip = 0x7F000001, .port = 2});
  there->set_receive_buffer(roomy);
  const auto to_group = std::make_shared<Lane>(there, 100, tally);
  const auto group = std::make_shared<GroupOf>(*to);
  to_group->tell(group);
  for (const auto& each : {to_group, own}) {
    each->post(job(large_bytes));
    flows.add(each);
  }
  serve_small();
  flows.send_large(1);
  EXPECT_EQ(bytes_left(), 0U) << "the group has not begun with the older one";
  flows.send_large(0);
  EXPECT_GT(bytes_left(), large_bytes);
  flows.send_large(1);
  EXPECT_GT(bytes_left(), 2 * large_bytes);
  flows.forget_idle();
  for (const auto& each : {own, to_group}) {
    each->post(job(large_bytes));
    flows.add(each);
  }
  serve_small();
  flows.send_large(0);
  EXPECT_GT(bytes_left(), 3 * large_bytes) << "it does not wait for what is younger";
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

}  // namespace
}  // namespace sft::udp
