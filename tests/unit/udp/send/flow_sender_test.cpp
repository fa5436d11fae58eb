#include "udp_transport/send/flow_sender.h"

#include <gtest/gtest.h>

#include "tests/unit/udp/send/sending.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;
using Progress = FlowSender::Progress;

using test::large_bytes;
using test::small_bytes;

class FlowSenderTest : public testing::Test, protected test::Sending {
 protected:
  SendFlow flow(std::size_t bytes) {
    sent_job = job(bytes);
    SendFlow made{.lane = lane(), .size = KeptSamples::size_of(sent_job->first.total)};
    made.fragments.emplace(sent_job->body(), to->path().datagram_bytes());
    return made;
  }
  /// Sends until the flow has to wait or ends. Returns the progress of the last call.
  Progress send(SendFlow& flow) {
    Progress progress = Progress::some;
    while (progress == Progress::some) progress = sender.send_a_few(flow, now);
    return progress;
  }

  FlowSender::Time now{1h};
  JobHandle sent_job;
};

TEST_F(FlowSenderTest, SendsASmallSampleInOneCall) {
  SendFlow one = flow(small_bytes);
  EXPECT_EQ(sender.send_a_few(one, now), Progress::whole);
  EXPECT_EQ(connections.sent().size(), 1U);
  EXPECT_EQ(tally->bytes_sent, bytes_left());
}

TEST_F(FlowSenderTest, LooksWhetherReadersOnThisHostHaveTheirTurnWhereASampleIsLarge) {
  const auto much_later = std::chrono::steady_clock::now() + 1h;
  local_turns.begin();
  local_turns.end();
  SendFlow small = flow(small_bytes);
  sender.send_some(small);
  SendFlow large = flow(large_bytes);
  EXPECT_TRUE(local_turns.is_due(much_later)) << "nobody has looked yet";
  local_turns.begin();
  local_turns.end();
  sender.send_some(large);
  EXPECT_FALSE(local_turns.is_due(much_later + 1h)) << "the sender has seen the turn, and it has passed";
}

TEST_F(FlowSenderTest, SendsALargeSampleInSeveralCalls) {
  SendFlow one = flow(large_bytes);
  EXPECT_EQ(sender.send_a_few(one, now), Progress::some);
  EXPECT_LT(bytes_left(), large_bytes / 2);
  EXPECT_EQ(send(one), Progress::whole);
  EXPECT_GT(bytes_left(), large_bytes);
  EXPECT_EQ(tally->bytes_sent, bytes_left());
  EXPECT_EQ(one.behind, to->window().position());
}

TEST_F(FlowSenderTest, GoesOnBehindWhatTheSendBufferTook) {
  to->note(SendOutcome::no_segments);  // makes each call send several batches
  SendFlow one = flow(large_bytes);
  connections.take_batches(3);
  EXPECT_EQ(send(one), Progress::none);
  EXPECT_EQ(round.time(), now + FlowSender::timeout);
  connections.take_batches(SIZE_MAX);
  EXPECT_EQ(send(one), Progress::whole);
  EXPECT_EQ(connections.sent(), test::cut(sent_job->body(), to->path().datagram_bytes())) << "nothing twice";
}

TEST_F(FlowSenderTest, LosesASampleWhoseConnectionStaysFull) {
  SendFlow one = flow(large_bytes);
  connections.take_batches(0);
  EXPECT_EQ(sender.send_a_few(one, now), Progress::none);
  EXPECT_EQ(sender.send_a_few(one, now + FlowSender::timeout - 1ms), Progress::none);
  EXPECT_EQ(sender.send_a_few(one, now + FlowSender::timeout), Progress::lost);
}

TEST_F(FlowSenderTest, WaitsForTheWholeTimeoutAgainWhenSomethingHasLeft) {
  SendFlow one = flow(large_bytes);
  connections.take_batches(0);
  EXPECT_EQ(send(one), Progress::none);
  now += FlowSender::timeout - 1ms;
  connections.take_batches(1);
  EXPECT_EQ(send(one), Progress::none);
  now += 1s;
  EXPECT_EQ(sender.send_a_few(one, now), Progress::none);
}

TEST_F(FlowSenderTest, WaitsUntilTheRateOfItsWriterAllowsMore) {
  tally = std::make_shared<WriterTally>(1'000'000);
  SendFlow one = flow(large_bytes);
  EXPECT_EQ(send(one), Progress::none);
  EXPECT_GT(round.time(), now);
  EXPECT_LT(round.time(), now + 1s);
  const std::size_t before = bytes_left();
  now = round.time();
  send(one);
  EXPECT_GT(bytes_left(), before);
}

TEST_F(FlowSenderTest, AsksForARoundAtOnceIfATurnWasNotEnough) {
  to->note(SendOutcome::no_segments);  // makes each batch have one datagram
  SendFlow one = flow(large_bytes);
  EXPECT_EQ(sender.send_some(one), Progress::some);
  EXPECT_LT(bytes_left(), large_bytes);
  EXPECT_EQ(round.time(), NextRound::Time{}) << "others go on before this one does";
}

}  // namespace
}  // namespace sft::udp
