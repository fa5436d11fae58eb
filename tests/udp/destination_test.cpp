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
  test::Connections connections_;
  DestinationDirectory directory_{{.bytes_per_s = 600'000'000}, connections_.connect()};
};

TEST_F(DestinationTest, BelievesNoSmallerReceiveBufferThanEverySystemGrants) {
  for (const std::uint32_t announced : {0U, 1U, 1000U, 212'992U}) {
    EXPECT_EQ(find(announced)->burst_bytes(), 212'992U / 2) << announced;
  }
  EXPECT_EQ(find(1'000'000)->burst_bytes(), 500'000U);
}

TEST_F(DestinationTest, GoesOnWithinMillisecondsWhateverWasAnnounced) {
  for (const std::uint32_t announced : {0U, 1U, 2U, 212'992U, ~0U}) {
    const auto to = find(announced);
    const Pacer::Time now = Pacer::Time{} + 1h;
    to->pacer().set_burst(to->burst_bytes());
    for (int i = 0; i < 100'000 && to->pacer().ready(now); ++i) to->pacer().spend(65'507);
    EXPECT_GT(to->pacer().next_ready(now), now) << announced;
    EXPECT_LT(to->pacer().next_ready(now), now + 10ms) << announced;
  }
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
