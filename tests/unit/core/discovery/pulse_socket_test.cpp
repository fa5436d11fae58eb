// Pulses go by multicast on one link, and wait in the socket until they are taken.
#include "core/discovery/pulse_socket.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <optional>
#include <vector>

#include "core/platform/file_descriptor.h"

namespace sft::core {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr std::uint16_t port = 47'404;
const PulseSocket::Place on_loopback{.ip = loopback_ipv4, .index = 1, .port = port, .reaches_own_host = true};

std::vector<Pulse> taken(PulseSocket& socket) {
  std::vector<Pulse> pulses;
  socket.take([&](const Pulse& pulse) { pulses.push_back(pulse); });
  return pulses;
}

/// Sends from the loopback, to the group or to an address of the host.
void send_octets(const char* to, const std::vector<std::byte>& octets) {
  const FileDescriptor socket(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  const in_addr link{htonl(INADDR_LOOPBACK)};
  ::setsockopt(socket.get(), IPPROTO_IP, IP_MULTICAST_IF, &link, sizeof link);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  ::inet_pton(AF_INET, to, &address.sin_addr);
  ::sendto(socket.get(), octets.data(), octets.size(), 0, reinterpret_cast<const sockaddr*>(&address),
           sizeof address);
}

class PulseSocketTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!one || !other) GTEST_SKIP() << "the loopback has no multicast here";
  }

  std::optional<PulseSocket> one = PulseSocket::open(on_loopback), other = PulseSocket::open(on_loopback);
  const Pulse pulse{.node = 77, .participant = 5};
};

TEST_F(PulseSocketTest, EachSocketOfTheHostGetsEachPulse) {
  one->send(pulse);
  EXPECT_THAT(taken(*one), ElementsAre(pulse));
  EXPECT_THAT(taken(*other), ElementsAre(pulse));
  EXPECT_THAT(taken(*other), IsEmpty());
}

TEST_F(PulseSocketTest, PulsesWaitUntilTheyAreTaken) {
  for (int i = 0; i < 100; ++i) one->send(pulse);
  EXPECT_THAT(taken(*other), SizeIs(100));
}

TEST_F(PulseSocketTest, OtherDatagramsAreDropped) {
  const PulseDatagram datagram = encode(pulse);
  std::vector<std::byte> octets(datagram.begin(), datagram.end());
  octets.push_back(std::byte{0});
  send_octets("239.255.0.1", octets);
  send_octets("239.255.0.1", {});
  send_octets("239.255.0.1", std::vector<std::byte>(1000));
  one->send(pulse);
  EXPECT_THAT(taken(*other), ElementsAre(pulse));
}

TEST_F(PulseSocketTest, WhatIsSentToTheHostItselfIsNotHeard) {
  const PulseDatagram datagram = encode(pulse);
  send_octets("127.0.0.1", {datagram.begin(), datagram.end()});
  EXPECT_THAT(taken(*other), IsEmpty());
}

TEST_F(PulseSocketTest, AFloodDoesNotHoldUpWhoTakes) {
  for (int i = 0; i < 64; ++i) one->send(pulse);
  std::size_t heard = 0;
  other->take([&](const Pulse&) {
    ++heard;
    one->send(pulse);  // so there is always another one
  });
  EXPECT_EQ(heard, PulseSocket::taken_at_once_max);
}

TEST(PulseSocketPlace, OnAnInterfaceThatIsNotThereIsNone) {
  EXPECT_FALSE(PulseSocket::open(
      {.ip = IpAddress(0xC0000201), .index = 4'000'000, .port = port, .reaches_own_host = false}));
}

}  // namespace
}  // namespace sft::core
