// Heartbeats are sent by multicast on one link, and wait in the socket until they are taken.
#include "core/discovery/heartbeat_socket.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <chrono>
#include <optional>
#include <vector>

#include "core/platform/file_descriptor.h"
#include "tests/support/eventually.h"

namespace sft::core {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr std::uint16_t test_port = 47'414;
const LinkSpec link_of_tests{.ip = loopback_ipv4, .reaches_own_host = true, .index = 1};

std::vector<Heartbeat> heartbeats_taken(HeartbeatSocket& socket) {
  std::vector<Heartbeat> heartbeats;
  socket.take([&](const Heartbeat& heartbeat, auto, auto) { heartbeats.push_back(heartbeat); });
  return heartbeats;
}

/// Sends octets from the loopback to the port of heartbeats. The destination is the group or an address of
/// the host.
void send_to_heartbeats(const char* to, const std::vector<std::byte>& octets) {
  const FileDescriptor socket(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  const in_addr link{htonl(INADDR_LOOPBACK)};
  ::setsockopt(socket.get(), IPPROTO_IP, IP_MULTICAST_IF, &link, sizeof link);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(test_port);
  ::inet_pton(AF_INET, to, &address.sin_addr);
  ::sendto(socket.get(), octets.data(), octets.size(), 0, reinterpret_cast<const sockaddr*>(&address),
           sizeof address);
}

class HeartbeatSocketTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!one || !other) GTEST_SKIP() << "the loopback has no multicast here";
  }

  std::optional<HeartbeatSocket> one = HeartbeatSocket::open(link_of_tests, test_port),
                                 other = HeartbeatSocket::open(link_of_tests, test_port);
  const Heartbeat heartbeat{.participant = {5}, .process = 77};
};

TEST_F(HeartbeatSocketTest, EachSocketOfTheHostGetsEachHeartbeat) {
  one->send(heartbeat);
  EXPECT_THAT(heartbeats_taken(*one), ElementsAre(heartbeat));
  EXPECT_THAT(heartbeats_taken(*other), ElementsAre(heartbeat));
  EXPECT_THAT(heartbeats_taken(*other), IsEmpty());
}

TEST_F(HeartbeatSocketTest, HeartbeatsWaitUntilTheyAreTaken) {
  for (int i = 0; i < 100; ++i) one->send(heartbeat);
  EXPECT_THAT(heartbeats_taken(*other), SizeIs(100));
}

/// The kernel begins to stamp datagrams shortly after the first socket has requested stamps.
TEST_F(HeartbeatSocketTest, SaysHowLongAHeartbeatHasWaited) {
  using namespace std::chrono_literals;
  std::chrono::nanoseconds waited{}, since_sent{};
  EXPECT_TRUE(test::eventually([&] {
    const auto sent = std::chrono::steady_clock::now();
    one->send(heartbeat);
    while (std::chrono::steady_clock::now() < sent + 20ms) heartbeats_taken(*one);
    other->take([&](const Heartbeat&, std::chrono::nanoseconds age, auto) { waited = age; });
    since_sent = std::chrono::steady_clock::now() - sent;
    return waited >= 10ms;
  }));
  EXPECT_LE(waited, since_sent + 1ms);
}

TEST_F(HeartbeatSocketTest, OtherDatagramsAreDropped) {
  const HeartbeatDatagram datagram = encode(heartbeat);
  std::vector<std::byte> octets(datagram.begin(), datagram.end());
  octets.push_back(std::byte{0});
  send_to_heartbeats("239.255.0.1", octets);
  send_to_heartbeats("239.255.0.1", {});
  send_to_heartbeats("239.255.0.1", std::vector<std::byte>(1000));
  one->send(heartbeat);
  EXPECT_THAT(heartbeats_taken(*other), ElementsAre(heartbeat));
}

TEST_F(HeartbeatSocketTest, WhatIsSentToTheHostItselfIsNotHeard) {
  const HeartbeatDatagram datagram = encode(heartbeat);
  send_to_heartbeats("127.0.0.1", {datagram.begin(), datagram.end()});
  EXPECT_THAT(heartbeats_taken(*other), IsEmpty());
}

TEST_F(HeartbeatSocketTest, AFloodDoesNotHoldUpWhoTakes) {
  for (int i = 0; i < 64; ++i) one->send(heartbeat);
  std::size_t heard = 0;
  other->take([&](const Heartbeat&, auto, auto) {
    ++heard;
    one->send(heartbeat);  // ensures that there is always a further heartbeat to take
  });
  EXPECT_EQ(heard, HeartbeatSocket::taken_at_once_max);
}

TEST(HeartbeatSocketOpen, OnAnInterfaceThatIsNotThereIsNone) {
  EXPECT_FALSE(HeartbeatSocket::open({.ip = IpAddress(0xC0000201), .index = 4'000'000}, test_port));
}

}  // namespace
}  // namespace sft::core
