// A heartbeat is a datagram with a fixed format; any other datagram is refused.
#include "core/discovery/heartbeat.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>
#include <vector>

namespace sft::core {
namespace {

using ::testing::Optional;

Heartbeat some() {
  Heartbeat heartbeat{.process = 0x0102030405060708, .digests = {0x1112131415161718, 0x2122232425262728}};
  std::iota(heartbeat.participant.begin(), heartbeat.participant.end(), std::uint8_t{0x40});
  return heartbeat;
}

TEST(HeartbeatTest, ComesAsItWasSent) { EXPECT_THAT(decode_heartbeat(encode(some())), Optional(some())); }

TEST(HeartbeatTest, HasTheFormThatIsDocumented) {
  std::vector<std::uint8_t> expected{'S', 'H', 'B', static_cast<std::uint8_t>(control_protocol_version())};
  for (std::uint8_t octet = 0x40; octet < 0x50; ++octet) expected.push_back(octet);
  for (const std::uint8_t last : {0x08, 0x18, 0x28}) {
    for (std::uint8_t i = 0; i < 8; ++i) expected.push_back(static_cast<std::uint8_t>(last - i));
  }
  std::vector<std::uint8_t> written;
  for (const std::byte octet : encode(some())) written.push_back(static_cast<std::uint8_t>(octet));
  EXPECT_EQ(written, expected);
}

TEST(HeartbeatTest, OfAnotherLengthIsNone) {
  const HeartbeatDatagram datagram = encode(some());
  std::vector<std::byte> octets(datagram.begin(), datagram.end());
  for (std::size_t size = 0; size < octets.size(); ++size)
    EXPECT_FALSE(decode_heartbeat(std::span(octets).first(size))) << size;
  octets.push_back(std::byte{0});
  EXPECT_FALSE(decode_heartbeat(octets));
}

TEST(HeartbeatTest, OfAnotherKindOrVersionIsNone) {
  for (std::size_t at = 0; at < 4; ++at) {
    HeartbeatDatagram datagram = encode(some());
    datagram[at] ^= std::byte{1};
    EXPECT_FALSE(decode_heartbeat(datagram)) << at;
  }
}

}  // namespace
}  // namespace sft::core
