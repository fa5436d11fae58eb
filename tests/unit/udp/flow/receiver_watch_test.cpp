#include "udp_transport/flow/receiver_watch.h"

#include <gtest/gtest.h>

namespace sft::udp {
namespace {

using namespace std::chrono_literals;

class ReceiverWatchTest : public testing::Test {
 protected:
  /// Time from a mark until the next one, when so many were not answered.
  ReceiverWatch::Time::duration pause() { return watch.next_retry(round_trips) - now; }

  const ReceiverWatch::Time now{1h};
  const FlowLimits limits{};
  RoundTrips round_trips{limits.mark_again_unheard};
  ReceiverWatch watch{limits};
};

TEST_F(ReceiverWatchTest, CallsAReceiverMuteAfterSeveralMarksAndASecondOfSilence) {
  for (const auto at : {0ms, 10ms}) watch.ask(true, now + at);
  EXPECT_FALSE(watch.is_mute(now + 10s)) << "one mark may get lost";
  watch.ask(true, now + 20ms);
  EXPECT_FALSE(watch.is_mute(now + 999ms));
  EXPECT_TRUE(watch.is_mute(now + 1s));
  EXPECT_FALSE(watch.is_silent(now + 1s)) << "it has never reported";
  watch.reported(now + 1s);
  EXPECT_FALSE(watch.is_mute(now + 10s));
}

TEST_F(ReceiverWatchTest, CountsAnewBehindAPauseInWhatIsSent) {
  for (const auto at : {0ms, 10ms, 4000ms}) watch.ask(true, now + at);
  EXPECT_FALSE(watch.is_mute(now + 10s)) << "only the third one counts";
  for (const auto at : {4010ms, 4020ms}) watch.ask(true, now + at);
  EXPECT_TRUE(watch.is_mute(now + 5s));
}

TEST_F(ReceiverWatchTest, BelievesAReceiverThatHasJustReportedMoreThanItsHost) {
  watch.reported(now);
  watch.refused(now + limits.mark_silent - 1ms);
  EXPECT_FALSE(watch.is_silent(now + 1s));
  watch.refused(now + limits.mark_silent);
  EXPECT_TRUE(watch.is_silent(now + 1s));
}

TEST_F(ReceiverWatchTest, AsksAtOnceAndThenEverMoreSeldom) {
  EXPECT_LE(watch.next_retry(round_trips), now);
  for (const auto pause_then : {10ms, 20ms, 40ms, 80ms, 160ms, 250ms}) {
    watch.ask(true, now);
    EXPECT_EQ(pause(), pause_then);
  }
}

TEST_F(ReceiverWatchTest, AsksSoonAgainOnAShortWay) {
  round_trips.note(1ms, now);
  watch.reported(now);
  watch.ask(false, now);
  EXPECT_EQ(pause(), limits.mark_again);
  for (int i = 0; i < 10; ++i) watch.ask(true, now);
  EXPECT_EQ(pause(), limits.mark_again_unheard) << "a missing answer was lost";
}

TEST_F(ReceiverWatchTest, HasToAskAnewMoreSeldomWhereAcksCome) {
  watch.reported(now);
  EXPECT_FALSE(watch.has_to_ask_anew(now + limits.mark_anew - 1ms));
  EXPECT_TRUE(watch.has_to_ask_anew(now + limits.mark_anew));
  watch.lives(now);
  EXPECT_FALSE(watch.has_to_ask_anew(now + limits.mark_anew));
  EXPECT_TRUE(watch.has_to_ask_anew(now + limits.mark_anew_behind_acks));
}

TEST_F(ReceiverWatchTest, KnowsWhenAMarkMayHaveBeenSent) {
  EXPECT_FALSE(watch.may_have_asked_at(now));
  watch.ask(false, now);
  watch.ask(false, now + 5ms);
  EXPECT_TRUE(watch.may_have_asked_at(now + 3ms));
  EXPECT_FALSE(watch.may_have_asked_at(now - 1ns));
  EXPECT_FALSE(watch.may_have_asked_at(now + 5ms + 1ns));
}

}  // namespace
}  // namespace sft::udp
