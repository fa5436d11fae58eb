#include "udp_transport/flow/destination.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/unit/udp/connections.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;

class DestinationTest : public testing::Test {
 protected:
  std::shared_ptr<Destination> find(std::uint32_t receive_buffer_bytes) {
    return directory_.find({0x7F000001, 5000, receive_buffer_bytes});
  }
  FlowReport answer_to_mark(std::uint32_t window_bytes = 1'000'000) const {
    return connections_.answer_to_mark(window_bytes);
  }
  const core::IpAddress there_{0x7F000001U}, elsewhere_{0x0A090003U};
  const Destination::Time now_ = Destination::Time{} + 1h;
  test::Connections connections_;
  DestinationDirectory directory_{{.report_port = 7}, connections_.connect()};
};

TEST_F(DestinationTest, HasAConnectionForWhatIsSmallAndAnotherForWhatIsLarge) {
  const auto to = find(0);
  EXPECT_EQ(connections_.open(), 1U);
  EXPECT_EQ(&to->connection_after(to->position()), &to->connection());
  EXPECT_NE(&to->bulk(), &to->connection());
  EXPECT_EQ(connections_.open(), 2U);
}

TEST_F(DestinationTest, SendsWhatMustNotOvertakeBehindIt) {
  const auto to = find(0);
  to->sent(to->connection(), 100, 1, now_);
  ASSERT_TRUE(to->hear(answer_to_mark(200'000), there_, now_).believed);
  to->sent(to->bulk(), 100'000, 70, now_);
  EXPECT_EQ(&to->connection_after(to->position()), &to->bulk());
  ASSERT_TRUE(to->hear(answer_to_mark(), there_, now_ + 1ms).believed);
  EXPECT_EQ(&to->connection_after(to->position()), &to->connection()) << "it has arrived";
}

TEST_F(DestinationTest, BelievesAReportThatRepeatsItsMarkAndLearnsWhereTheReceiverIs) {
  const auto to = find(0);
  EXPECT_FALSE(to->answers());
  to->sent(to->connection(), 100, 1, now_);
  FlowReport guess = answer_to_mark();
  guess.sent_at_ns = now_.time_since_epoch().count();
  EXPECT_FALSE(to->hear(guess, there_, now_).believed) << "only who got the mark knows the time in it";
  EXPECT_FALSE(to->hear(guess, elsewhere_, now_).believed);
  EXPECT_FALSE(to->is_at(elsewhere_));
  EXPECT_FALSE(to->answers());
  EXPECT_TRUE(to->is_at(there_));
  EXPECT_TRUE(to->hear(answer_to_mark(), elsewhere_, now_).believed);
  EXPECT_TRUE(to->is_at(elsewhere_)) << "it has another address, too";
  EXPECT_TRUE(to->answers());
}

TEST_F(DestinationTest, HasToAnswerAnewWhereItHasMovedTo) {
  const auto to = directory_.find({.ip = there_, .port = 5000, .node = 7});
  to->sent(to->connection(), 100, 1, now_);
  const FlowReport before = answer_to_mark();
  ASSERT_TRUE(to->hear(before, there_, now_).believed);
  directory_.find({.ip = elsewhere_, .port = 5000, .node = 7});
  EXPECT_FALSE(to->answers());
  EXPECT_FALSE(to->is_at(there_));
  EXPECT_FALSE(to->hear(before, there_, now_).believed);
  EXPECT_EQ(to->room(Destination::Size::large, now_), 0U);
  to->mark(now_);
  EXPECT_TRUE(to->hear(answer_to_mark(), elsewhere_, now_).believed);
  EXPECT_GT(to->room(Destination::Size::large, now_), 0U);
}

TEST_F(DestinationTest, SendsNoHeartbeatsToWhoDoesNotAnswerAndThenOneAtOnce) {
  const auto to = find(0);
  int few = 0;
  for (; few < 100 && to->takes_control(now_); ++few) {
  }
  EXPECT_EQ(few, 16);
  EXPECT_EQ(to->moves(), 0U);
  to->sent(to->connection(), 100, 1, now_);
  ASSERT_TRUE(to->hear(answer_to_mark(), there_, now_).believed);
  EXPECT_EQ(to->moves(), 1U) << "channels ask again at once";
  EXPECT_TRUE(to->takes_control(now_));
}

TEST_F(DestinationTest, HasANumberThatNobodyGuesses) {
  const auto one = directory_.find({there_, 1}), two = directory_.find({there_, 2});
  EXPECT_GT(std::max(one->flow() - two->flow(), two->flow() - one->flow()), 1000U);
}

TEST_F(DestinationTest, IsFoundByTheNumberThatItsReceiverKnows) {
  const auto one = find(0);
  const auto other = directory_.find({0x7F000001, 5001, 0});
  EXPECT_EQ(directory_.of_flow(one->flow()), one);
  EXPECT_EQ(directory_.of_flow(other->flow()), other);
  EXPECT_EQ(directory_.of_flow(other->flow() + 1), nullptr);
}

TEST_F(DestinationTest, LooksForTheWayAnewAfterARefusal) {
  const auto to = find(0);
  to->note(SendOutcome::no_segments);
  EXPECT_EQ(connections_.reconnected(), 0U);
  EXPECT_EQ(to->datagrams_per_call(), 1U);
  to->note(SendOutcome::too_long);
  to->note(SendOutcome::failed);
  EXPECT_EQ(connections_.reconnected(), 2U);
}

TEST_F(DestinationTest, MovesToAnotherAddressOfTheSameSocket) {
  const auto at = [&](std::uint32_t ip, std::uint64_t node, std::uint16_t port = 5000) {
    return directory_.find({.ip = ip, .port = port, .node = node});
  };
  const auto there = at(1, 7);
  EXPECT_EQ(at(1, 7), there);
  EXPECT_EQ(there->moves(), 0U);
  EXPECT_EQ(at(2, 7), there);
  EXPECT_EQ(there->moves(), 1U);
  EXPECT_EQ(there->address(), (SocketAddress{2, 5000}));
  EXPECT_EQ(connections_.redirected(), (std::vector<SocketAddress>{{2, 5000}}));
  EXPECT_NE(at(2, 7, 5001), there) << "it is another socket of that node";
  EXPECT_NE(at(2, 8), there) << "it is another node, by an address that changed hands";
  EXPECT_EQ(connections_.open(), 1U) << "those two are gone";
}

TEST_F(DestinationTest, IsFoundByWhereItIsWhenNobodySaysWhoseItIs) {
  const auto there = directory_.find({.ip = 1, .port = 5000, .node = 7});
  directory_.find({.ip = 2, .port = 5000, .node = 7});
  EXPECT_EQ(directory_.find({.ip = 2, .port = 5000}), there);
  EXPECT_EQ(there->address(), (SocketAddress{2, 5000}));
  EXPECT_NE(directory_.find({.ip = 1, .port = 5000}), there);
}

}  // namespace
}  // namespace sft::udp
