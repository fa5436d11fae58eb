#include "udp_transport/flow/destination.h"

#include <gtest/gtest.h>

#include "tests/support/parse_datagram.h"
#include "tests/unit/udp/connections.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;

class DestinationTest : public testing::Test {
 protected:
  FlowReport answer_to_mark(std::uint32_t window_bytes = 1'000'000) const {
    return connections_.answer_to_mark(window_bytes);
  }

  const core::IpAddress there_{0x7F000001U}, elsewhere_{0x0A090003U};
  const Destination::Time now_ = Destination::Time{} + 1h;
  test::Connections connections_;
  Destination to_{{there_, 5000}, {.report_port = 7}, 99, connections_.connect()};
};

TEST_F(DestinationTest, SendsWhatMustNotOvertakeBehindIt) {
  to_.sent(to_.connection(), 100, 1, 100, now_);
  ASSERT_TRUE(to_.hear(answer_to_mark(200'000), there_, now_).accepted);
  EXPECT_EQ(&to_.connection_after(to_.window().position()), &to_.connection());
  to_.sent(to_.bulk(), 100'000, 70, 1472, now_);
  EXPECT_EQ(&to_.connection_after(to_.window().position()), &to_.bulk());
  EXPECT_EQ(&to_.connection_after(0), &to_.connection()) << "nothing comes before position 0";
  ASSERT_TRUE(to_.hear(answer_to_mark(), there_, now_ + 1ms).accepted);
  EXPECT_EQ(&to_.connection_after(to_.window().position()), &to_.connection()) << "it has arrived";
}

TEST_F(DestinationTest, BelievesAReportThatRepeatsItsMarkAndLearnsWhereTheReceiverIs) {
  EXPECT_FALSE(to_.window().answers());
  to_.sent(to_.connection(), 100, 1, 100, now_);
  FlowReport guess = answer_to_mark();
  guess.sent_at_ns = now_.time_since_epoch().count();
  EXPECT_FALSE(to_.hear(guess, there_, now_).accepted) << "only who got the mark knows the time in it";
  EXPECT_FALSE(to_.hear(guess, elsewhere_, now_).accepted);
  EXPECT_FALSE(to_.path().is_at(elsewhere_));
  EXPECT_FALSE(to_.window().answers());
  EXPECT_TRUE(to_.path().is_at(there_));
  EXPECT_TRUE(to_.hear(answer_to_mark(), elsewhere_, now_).accepted);
  EXPECT_TRUE(to_.path().is_at(elsewhere_)) << "it has another address, too";
  EXPECT_TRUE(to_.window().answers());
}

TEST_F(DestinationTest, HasToAnswerAnewWhereItHasMovedTo) {
  to_.sent(to_.connection(), 100, 1, 100, now_);
  const FlowReport before = answer_to_mark();
  ASSERT_TRUE(to_.hear(before, there_, now_).accepted);
  to_.move_to({elsewhere_, 5000}, {});
  EXPECT_FALSE(to_.window().answers());
  EXPECT_FALSE(to_.path().is_at(there_));
  EXPECT_FALSE(to_.hear(before, there_, now_).accepted);
  EXPECT_EQ(to_.room(Destination::Size::large, now_), 0U);
  to_.mark(now_);
  EXPECT_TRUE(to_.hear(answer_to_mark(), elsewhere_, now_).accepted);
  EXPECT_GT(to_.room(Destination::Size::large, now_), 0U);
}

TEST_F(DestinationTest, CountsItsMovesToOtherAddresses) {
  EXPECT_EQ(to_.moves(), 0U);
  to_.move_to({there_, 5000}, {});
  EXPECT_EQ(to_.moves(), 0U) << "it is there already";
  to_.move_to({elsewhere_, 5000}, {});
  EXPECT_EQ(to_.moves(), 1U);
  EXPECT_EQ(connections_.redirected(), (std::vector<SocketAddress>{{elsewhere_, 5000}}));
}

TEST_F(DestinationTest, SendsNoHeartbeatsToWhoDoesNotAnswerAndThenOneAtOnce) {
  int few = 0;
  for (; few < 100 && to_.takes_control(now_); ++few) {
  }
  EXPECT_EQ(few, 16);
  EXPECT_EQ(to_.moves(), 0U);
  to_.sent(to_.connection(), 100, 1, 100, now_);
  ASSERT_TRUE(to_.hear(answer_to_mark(), there_, now_).accepted);
  EXPECT_EQ(to_.moves(), 1U) << "channels ask again at once";
  EXPECT_TRUE(to_.takes_control(now_));
}

TEST_F(DestinationTest, AsksWhoNeverAnsweredAlsoIfNothingButHeartbeatsIsLeftToSend) {
  to_.sent(to_.connection(), 1000, 16, 100, now_);
  const std::size_t first = connections_.sent().size();
  EXPECT_EQ(first, 1U);
  Destination::Time time = now_;
  for (; time < now_ + 10s; time += 1s) EXPECT_FALSE(to_.takes_control(time));
  EXPECT_GE(connections_.sent().size(), first + 5) << "of marks";
  ASSERT_TRUE(to_.hear(answer_to_mark(), there_, time).accepted);
  EXPECT_TRUE(to_.takes_control(time));
}

TEST_F(DestinationTest, AsksWhoFellSilentAlsoIfNothingButHeartbeatsIsLeftToSend) {
  to_.sent(to_.connection(), 100, 1, 100, now_);
  ASSERT_TRUE(to_.hear(answer_to_mark(), there_, now_).accepted);
  Destination::Time time = now_;
  for (; to_.takes_control(time); time += 300ms) {
    ASSERT_LT(time, now_ + 20s);
    if (time < now_ + 5s) to_.sent(to_.connection(), 100, 1, 100, time);
  }
  const std::size_t before = connections_.sent().size();
  for (const Destination::Time end = time + 5s; time < end; time += 1s) EXPECT_FALSE(to_.takes_control(time));
  EXPECT_GE(connections_.sent().size(), before + 4) << "of marks";
  ASSERT_TRUE(to_.hear(answer_to_mark(), there_, time).accepted);
  EXPECT_TRUE(to_.takes_control(time));
}

TEST_F(DestinationTest, SendsMarksThatNameThePortForReports) {
  to_.mark(now_);
  ASSERT_EQ(connections_.sent().size(), 1U);
  const auto mark = parse_as<FlowMark>(connections_.sent().front());
  ASSERT_TRUE(mark);
  EXPECT_EQ(mark->flow, 99U);
  EXPECT_EQ(mark->port, 7U);
}

TEST_F(DestinationTest, LooksForTheWayAnewAfterARefusal) {
  to_.note(SendOutcome::no_segments);
  EXPECT_EQ(connections_.reconnected(), 0U);
  EXPECT_EQ(to_.datagrams_per_call(), 1U);
  to_.note(SendOutcome::too_long);
  to_.note(SendOutcome::failed);
  EXPECT_EQ(connections_.reconnected(), 2U);
}

TEST_F(DestinationTest, SendsShorterDatagramsWhereReportsShowThatLongOnesDoNotArriveAndSaysSoOnce) {
  const std::size_t before = to_.path().datagram_bytes();
  EXPECT_EQ(to_.take_limit_change(), Destination::Change::none);
  test::lose_long_ones(to_, connections_, now_);
  EXPECT_LT(to_.path().datagram_bytes(), before);
  EXPECT_EQ(to_.path().limit_in_words(),
            "datagrams longer than 1252 bytes do not arrive at '127.0.0.1': "
            "samples go there in shorter ones");
  EXPECT_EQ(to_.take_limit_change(), Destination::Change::found);
  EXPECT_EQ(to_.take_limit_change(), Destination::Change::none);
}

TEST_F(DestinationTest, SaysThatALimitIsOverOnceLongDatagramsArriveAgain) {
  auto now = test::lose_long_ones(to_, connections_, now_);
  to_.take_limit_change();
  for (int tries = 0; tries < 20 && to_.path().limited_to() != 0; ++tries) {
    now += PathMtu::retry_pause;
    to_.look_after(now, false);
    test::report_all(to_, connections_, now);
  }
  EXPECT_EQ(to_.take_limit_change(), Destination::Change::over);
  EXPECT_EQ(
      to_.path().no_limit_in_words(),
      "long datagrams no longer get lost on the way to '127.0.0.1': samples go there in datagrams of up "
      "to 65507 bytes");
}

TEST_F(DestinationTest, AsksSoonOnceSomethingIsAskedForAgainAndNotBefore) {
  to_.sent(to_.connection(), 1000, 1, 1000, now_);
  ASSERT_TRUE(to_.hear(answer_to_mark(), there_, now_).accepted);
  const std::size_t marks = connections_.sent().size();
  to_.sent(to_.connection(), 1000, 1, 1000, now_ + 100ms);
  EXPECT_EQ(connections_.sent().size(), marks) << "a path without loss takes no further datagram";
  to_.asked_again();
  to_.lives(now_ + 199ms);
  to_.sent(to_.connection(), 1000, 1, 1000, now_ + 200ms);
  EXPECT_EQ(connections_.sent().size(), marks + 1);
}

}  // namespace
}  // namespace sft::udp
