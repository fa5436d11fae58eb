// The size of a flow window. The window grows if it limits the sender, and shrinks if a queue on the path is
// long.
#include "tests/unit/udp/flow/flow_window_fixture.h"

namespace sft::udp::test {
namespace {

TEST_F(FlowWindowTest, GrowsAgainWhereOneTrainFillsItAndIsReportedBeforeTheNextOne) {
  get_to_know(32 << 20);
  for (int i = 0; i < 100 && window.window() > FlowLimits{}.least_bytes; ++i) {
    send_while_there_is_room();
    answer(32 << 20, 300ms);  // the answer shows a long queue, and few bytes have arrived
  }
  ASSERT_EQ(window.window(), FlowLimits{}.least_bytes);
  constexpr std::size_t train_bytes = 64'000;
  for (int trains = 0; trains < 200; ++trains) {
    ASSERT_GT(window.room(Size::large, now), 0U);
    window.sent(train_bytes, 1, now);
    take_mark();
    answer(32 << 20);
  }
  EXPECT_GE(window.window(), 2 * train_bytes) << "so that the next one need not wait for the report";
}

TEST_F(FlowWindowTest, HoldsWhatAFastReceiverTakesInThreeMillisecondsThoughManyReportsInARowAreLate) {
  constexpr std::uint64_t bytes_per_ms = 1'000'000;
  get_to_know(32 << 20);
  take_for(100ms, bytes_per_ms);
  for (int seconds = 0; seconds < 3; ++seconds) {
    while (!marks.empty()) take_one(bytes_per_ms);
    now += 1s;
    take_for(10ms, bytes_per_ms);
  }
  for (int late = 0; late < 8; ++late) {
    send_while_there_is_room();
    now += 20ms;
    while (!marks.empty()) take_one(bytes_per_ms);
  }
  EXPECT_GE(window.window(), 3 * bytes_per_ms);
}

TEST_F(FlowWindowTest, KnowsNothingOfTheRateOnAnotherWay) {
  get_to_know(32 << 20);
  take_for(100ms, 1'000'000);
  window.move(1);
  marks.clear();
  get_to_know(32 << 20);
  send_while_there_is_room();
  answer(32 << 20, 20ms);
  EXPECT_LT(window.window(), FlowLimits{}.first_bytes);
}

TEST_F(FlowWindowTest, ShrinksUntilASlowReceiverHasNoLongQueue) {
  get_to_know(32 << 20);
  take_for(300ms, 1'000'000);
  for (const std::uint64_t bytes_per_ms : {100'000U, 10'000U}) {
    take_for(2s, bytes_per_ms);
    EXPECT_LE(window.window() / bytes_per_ms, 6U) << "milliseconds";
  }
}

}  // namespace
}  // namespace sft::udp::test
