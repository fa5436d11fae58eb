#include "udp_transport/destination.h"

#include <gtest/gtest.h>

#include "connections.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;

class DestinationTest : public testing::Test {
 protected:
  std::shared_ptr<Destination> find(std::uint32_t receive_buffer_bytes) {
    return directory_.find({0x7F000001, 5000, receive_buffer_bytes});
  }
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
  FlowReport report{.flow = to->flow(), .window_bytes = 1'000'000};
  ASSERT_FALSE(to->hear(report, now_));
  to->sent(to->bulk(), 100'000, 70, now_);
  EXPECT_EQ(&to->connection_after(to->position()), &to->bulk());
  report.position = to->position();
  ASSERT_FALSE(to->hear(report, now_ + 1ms));
  EXPECT_EQ(&to->connection_after(to->position()), &to->connection()) << "it has arrived";
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
