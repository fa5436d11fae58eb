#include "udp_transport/flow/receiver_monitor.h"

#include <gtest/gtest.h>

namespace sft::udp {
namespace {

using namespace std::chrono_literals;

class ReceiverMonitorTest : public testing::Test {
 protected:
  /// Returns the time from a flow mark to the next one. It depends on the number of unanswered marks so far.
  ReceiverMonitor::Time::duration pause() { return monitor.next_retry(round_trips) - now; }

  const ReceiverMonitor::Time now{1h};
  const FlowLimits limits{};
  RoundTrips round_trips{limits.mark_again_unheard};
  ReceiverMonitor monitor{limits};
};

TEST_F(ReceiverMonitorTest, CallsAReceiverMuteAfterSeveralMarksAndASecondOfSilence) {
  for (const auto at : {0ms, 10ms}) monitor.ask(true, now + at);
  EXPECT_FALSE(monitor.is_mute(now + 10s)) << "one mark may get lost";
  monitor.ask(true, now + 20ms);
  EXPECT_FALSE(monitor.is_mute(now + 999ms));
  EXPECT_TRUE(monitor.is_mute(now + 1s));
  EXPECT_FALSE(monitor.is_silent(now + 1s)) << "it has never reported";
  monitor.reported(now + 1s);
  EXPECT_FALSE(monitor.is_mute(now + 10s));
}

TEST_F(ReceiverMonitorTest, CountsAnewBehindAPauseInWhatIsSent) {
  for (const auto at : {0ms, 10ms, 4000ms}) monitor.ask(true, now + at);
  EXPECT_FALSE(monitor.is_mute(now + 10s)) << "only the third one counts";
  for (const auto at : {4010ms, 4020ms}) monitor.ask(true, now + at);
  EXPECT_TRUE(monitor.is_mute(now + 5s));
}

TEST_F(ReceiverMonitorTest, AcceptsAReceiverThatHasJustReportedMoreThanItsHost) {
  monitor.reported(now);
  monitor.refused(now + limits.mark_silent - 1ms);
  EXPECT_FALSE(monitor.is_silent(now + 1s));
  monitor.refused(now + limits.mark_silent);
  EXPECT_TRUE(monitor.is_silent(now + 1s));
}

TEST_F(ReceiverMonitorTest, ForgetsARefusalOnceTheReceiverReportsOrHasAnotherAddress) {
  const auto is_refusing = [&] {
    monitor.ask(false, now);
    return monitor.is_mute(now);
  };
  monitor.refused(now);
  EXPECT_TRUE(is_refusing());
  monitor.reported(now);
  EXPECT_FALSE(is_refusing());
  monitor.refused(now + limits.mark_silent);
  EXPECT_TRUE(is_refusing());
  monitor.begin_anew();
  EXPECT_FALSE(is_refusing());
}

TEST_F(ReceiverMonitorTest, AsksAtOnceAndThenEverMoreSeldom) {
  EXPECT_LE(monitor.next_retry(round_trips), now);
  for (const auto pause_then : {10ms, 20ms, 40ms, 80ms, 160ms, 250ms}) {
    monitor.ask(true, now);
    EXPECT_EQ(pause(), pause_then);
  }
}

TEST_F(ReceiverMonitorTest, AsksSoonAgainOnAShortWay) {
  round_trips.note(1ms, now);
  monitor.reported(now);
  monitor.ask(false, now);
  EXPECT_EQ(pause(), limits.mark_again);
  for (int i = 0; i < 10; ++i) monitor.ask(true, now);
  EXPECT_EQ(pause(), limits.mark_again_unheard) << "a missing answer was lost";
}

TEST_F(ReceiverMonitorTest, HasToAskAnewMoreSeldomWhereAcksCome) {
  monitor.reported(now);
  EXPECT_FALSE(monitor.has_to_ask_anew(now + limits.mark_anew - 1ms));
  EXPECT_TRUE(monitor.has_to_ask_anew(now + limits.mark_anew));
  monitor.lives(now);
  EXPECT_FALSE(monitor.has_to_ask_anew(now + limits.mark_anew));
  EXPECT_TRUE(monitor.has_to_ask_anew(now + limits.mark_anew_behind_acks));
}

TEST_F(ReceiverMonitorTest, KnowsWhenAMarkMayHaveBeenSent) {
  EXPECT_FALSE(monitor.may_have_asked_at(now));
  monitor.ask(false, now);
  monitor.ask(false, now + 5ms);
  EXPECT_TRUE(monitor.may_have_asked_at(now + 3ms));
  EXPECT_FALSE(monitor.may_have_asked_at(now - 1ns));
  EXPECT_FALSE(monitor.may_have_asked_at(now + 5ms + 1ns));
}

}  // namespace
}  // namespace sft::udp
