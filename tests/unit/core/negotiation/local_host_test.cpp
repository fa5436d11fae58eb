// Tests what is announced with the endpoints of this node, and at which address readers are reached.
#include "core/negotiation/local_host.h"

#include <gtest/gtest.h>

namespace sft::core {
namespace {

class LocalHostTest : public ::testing::Test {
 protected:
  LocalHostTest() {
    token.bytes.fill(1);
    host.self_changed(self());
  }
  Self self() const { return {.host = token, .network = 1, .memory_state = "ready"}; }
  Endpoint equipped(Role role, bool may_use_network = true) const {
    Endpoint ours;
    ours.role = role;
    ours.may_use_network = may_use_network;
    host.equip(ours);
    return ours;
  }

  const std::vector<UdpAddress> addresses{{0x0a000001, 7000, 1 << 20}};
  HostToken token;
  LocalHost host;
};

TEST_F(LocalHostTest, OnlyAChangeIsNews) {
  EXPECT_FALSE(host.self_changed(self()));
  Self other = self();
  other.network = 2;
  EXPECT_TRUE(host.self_changed(other));
  EXPECT_EQ(equipped(Role::reader).network, 2U);
}

TEST_F(LocalHostTest, AWriterThatMayOnlyReadSharedMemoryGetsNoToken) {
  Self read_only = self();
  read_only.may_write_memory = false;
  host.self_changed(read_only);
  EXPECT_EQ(equipped(Role::reader).host, token);
  EXPECT_FALSE(equipped(Role::writer).host.known());
}

TEST_F(LocalHostTest, AnEndpointSaysWhyItsNodeHasNoSharedMemoryUnlessItRulesThatOut) {
  host.self_changed({.memory_state = "starting again", .memory_failure = "/dev/shm is too small"});
  Endpoint ours;
  ours.may_use_memory = true;
  host.equip(ours);
  EXPECT_EQ(ours.memory_failure, "/dev/shm is too small");
  ours.may_use_memory = false;
  host.equip(ours);
  EXPECT_EQ(ours.memory_failure, "");
}

TEST_F(LocalHostTest, AnEndpointThatMayUseUdpGetsTheAddresses) {
  host.network_changed(addresses, {});
  EXPECT_EQ(equipped(Role::reader).addresses, addresses);
  EXPECT_TRUE(equipped(Role::reader, false).addresses.empty());
}

TEST_F(LocalHostTest, AReaderInTheSameNetworkStackIsReachedByLoopback) {
  Endpoint reader;
  reader.node_id = 77;
  reader.network = 1;
  reader.addresses = addresses;
  const UdpAddress address = host.address_of(reader);
  EXPECT_EQ(address.ip, loopback_ipv4);
  EXPECT_EQ(address.port, 7000);
  EXPECT_EQ(address.node, 77U);
  reader.network = 2;
  EXPECT_EQ(host.address_of(reader).ip, addresses.front().ip);
}

}  // namespace
}  // namespace sft::core
