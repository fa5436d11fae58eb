#include "udp_transport/flow/shared_flow_window.h"

#include <gtest/gtest.h>

#include <optional>

namespace sft::udp {
namespace {

using namespace std::chrono_literals;
using Size = SharedFlowWindow::Size;

class SharedFlowWindowTest : public testing::Test {
 protected:
  static FlowReport answer(const FlowMark& mark, std::uint32_t window_bytes = 1'000'000) {
    return {.flow = mark.flow,
            .position = mark.position,
            .window_bytes = window_bytes,
            .datagrams = mark.datagrams,
            .came = mark.datagrams,
            .sent_at_ns = mark.sent_at_ns};
  }
  /// Sends the first flow mark. The receiver answers it.
  void get_to_know() {
    const std::optional<FlowMark> mark = window_.sent(100, 1, 100, now_, false);
    ASSERT_TRUE(mark);
    ASSERT_TRUE(window_.hear(answer(*mark), now_).accepted);
  }

  static constexpr std::uint32_t flow = 7;
  static constexpr std::uint64_t secret = 0x1234'5678'9ABC'DEF0;
  SharedFlowWindow::Time now_{1h};
  SharedFlowWindow window_{flow, FlowLimits{}, secret};
};

TEST_F(SharedFlowWindowTest, KnowsTheReceiveBufferThatWasAnnounced) {
  EXPECT_EQ(window_.receive_buffer_bytes(), 0U);
  const std::size_t before = window_.batch_bytes();
  window_.announce(8 << 20);
  EXPECT_EQ(window_.receive_buffer_bytes(), 8U << 20);
  EXPECT_GT(window_.batch_bytes(), before);
}

TEST_F(SharedFlowWindowTest, AnswersFromTheFirstReportUntilALookFindsTheReceiverSilent) {
  EXPECT_FALSE(window_.answers());
  get_to_know();
  EXPECT_TRUE(window_.answers());
  for (int i = 0; i < 10; ++i, now_ += 200ms) {
    static_cast<void>(window_.sent(100, 1, 100, now_, false));
    static_cast<void>(window_.await_room(now_));
  }
  EXPECT_TRUE(window_.is_mute(now_));
  EXPECT_TRUE(window_.answers()) << "nobody has looked";
  EXPECT_EQ(window_.room(Size::large, now_), 0U);
  EXPECT_FALSE(window_.answers());
}

TEST_F(SharedFlowWindowTest, DoesNotAnswerAnyMoreOnceTheHostHasRefused) {
  get_to_know();
  static_cast<void>(window_.sent(100'000, 70, 1472, now_ + 1s, false));
  window_.refused(now_ + 1s);
  EXPECT_FALSE(window_.answers());
}

TEST_F(SharedFlowWindowTest, HasToAnswerAnewAfterAMove) {
  const std::optional<FlowMark> mark = window_.sent(100, 1, 100, now_, false);
  ASSERT_TRUE(mark);
  ASSERT_TRUE(window_.hear(answer(*mark), now_).accepted);
  window_.move(secret + 1, {});
  EXPECT_FALSE(window_.answers());
  EXPECT_FALSE(window_.hear(answer(*mark), now_).accepted);
  const std::optional<FlowMark> anew = window_.await_room(now_);
  ASSERT_TRUE(anew);
  EXPECT_TRUE(window_.hear(answer(*anew), now_).accepted);
  EXPECT_TRUE(window_.answers());
}

TEST_F(SharedFlowWindowTest, AnswersAlwaysIfNobodyIsAsked) {
  SharedFlowWindow unasked(flow, FlowLimits{.asks = false}, secret);
  EXPECT_TRUE(unasked.answers());
  EXPECT_FALSE(unasked.sent(100, 1, 100, now_, false)) << "no mark is due";
  unasked.move(secret + 1, {});
  EXPECT_TRUE(unasked.answers());
}

TEST_F(SharedFlowWindowTest, TellsOnceThatControlWasWithheldUntilTheReport) {
  while (window_.takes_control(now_)) {
  }
  std::optional<FlowMark> mark = window_.await_room(now_);
  ASSERT_TRUE(mark);
  EXPECT_TRUE(window_.hear(answer(*mark), now_).control_was_withheld);
  EXPECT_TRUE(window_.takes_control(now_));
  mark = window_.sent(1'000'000, 700, 1472, now_ + 1ms, false);
  ASSERT_TRUE(mark);
  EXPECT_FALSE(window_.hear(answer(*mark), now_ + 2ms).control_was_withheld);
}

TEST_F(SharedFlowWindowTest, KeepsThatControlWasWithheldUntilAReportIsBelieved) {
  while (window_.takes_control(now_)) {
  }
  const std::optional<FlowMark> mark = window_.await_room(now_);
  ASSERT_TRUE(mark);
  FlowReport guess = answer(*mark);
  guess.sent_at_ns = now_.time_since_epoch().count();
  EXPECT_FALSE(window_.hear(guess, now_).control_was_withheld);
  EXPECT_TRUE(window_.hear(answer(*mark), now_).control_was_withheld);
}

TEST_F(SharedFlowWindowTest, ReportsThatAThreadThatWaitedForRoomMayGoOn) {
  EXPECT_EQ(window_.room(Size::large, now_), 0U);
  const std::optional<FlowMark> mark = window_.await_room(now_);
  ASSERT_TRUE(mark);
  EXPECT_TRUE(window_.hear(answer(*mark), now_).goes_on);
  EXPECT_GT(window_.room(Size::large, now_), 0U);
}

TEST_F(SharedFlowWindowTest, CountsAPositionAsPassedOnceItIsReported) {
  get_to_know();
  EXPECT_TRUE(window_.passed(window_.position()));
  const std::optional<FlowMark> mark = window_.sent(1'000'000, 700, 1472, now_, false);
  ASSERT_TRUE(mark);
  EXPECT_FALSE(window_.passed(window_.position()));
  ASSERT_TRUE(window_.hear(answer(*mark), now_ + 3ms).accepted);
  EXPECT_TRUE(window_.passed(window_.position()));
  EXPECT_EQ(window_.round_trip(), 0ms) << "the first report came at once";
}

}  // namespace
}  // namespace sft::udp
