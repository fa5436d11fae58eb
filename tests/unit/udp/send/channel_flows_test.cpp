#include "udp_transport/send/channel_flows.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/parse_datagram.h"
#include "tests/unit/udp/send/sending.h"

namespace sft::udp {
namespace {

using test::small_bytes;

constexpr std::size_t image_bytes = 100'000;

class ChannelFlowsTest : public testing::Test, protected test::Sending {
 protected:
  ChannelFlowsTest() { flows.add(one); }

  void post(std::size_t bytes) {
    const JobHandle posted = job(bytes);
    one->post(posted, posted->first, false);
  }
  std::size_t heartbeats() const {
    return static_cast<std::size_t>(std::ranges::count_if(
        connections.sent(), [](const test::Bytes& bytes) { return parse_as<Heartbeat>(bytes).has_value(); }));
  }

  std::shared_ptr<Channel> one = channel();
  ChannelFlows flows{sender, round};
};

TEST_F(ChannelFlowsTest, SendsSmallSamplesAndAHeartbeat) {
  for (int i = 0; i < 3; ++i) post(small_bytes);
  flows.send_small();
  EXPECT_EQ(connections.sent().size(), 4U);
  EXPECT_EQ(heartbeats(), 1U);
  EXPECT_EQ(tally->bytes_sent, bytes_left());
}

TEST_F(ChannelFlowsTest, SendsOneLargeSampleInATurn) {
  post(image_bytes);
  post(image_bytes);
  flows.send_small();
  EXPECT_EQ(bytes_left(), 0U);
  flows.send_large(0);
  EXPECT_GT(bytes_left(), image_bytes);
  EXPECT_LT(bytes_left(), 2 * image_bytes);
  EXPECT_EQ(round.time(), NextRound::Time{}) << "another one waits";
  flows.send_large(0);
  EXPECT_GT(bytes_left(), 2 * image_bytes);
}

TEST_F(ChannelFlowsTest, ForgetsAChannelThatHasNothingLeftToLookAfter) {
  post(small_bytes);
  flows.send_small();
  flows.forget_resting();
  EXPECT_EQ(flows.count(), 1U) << "the sample is not acknowledged yet";
  static_cast<void>(one->hear({.writer = 1, .channel = 1, .next = 2}));
  round.begin();
  flows.send_small();
  EXPECT_EQ(round.time(), NextRound::Time{});
  flows.send_large(0);
  flows.forget_resting();
  EXPECT_EQ(flows.count(), 0U);
  EXPECT_EQ(one.use_count(), 1);
}

TEST_F(ChannelFlowsTest, GoesOnWithASampleThatHadNoRoom) {
  post(small_bytes);
  connections.take_batches(0);
  flows.send_small();
  EXPECT_EQ(connections.sent().size(), 0U);
  connections.take_batches(SIZE_MAX);
  flows.send_small();
  EXPECT_EQ(connections.sent().size(), 2U) << "the sample and a heartbeat";
}

}  // namespace
}  // namespace sft::udp
