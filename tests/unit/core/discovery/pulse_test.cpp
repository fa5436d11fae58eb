// A pulse is a datagram of a fixed form; anything else is none.
#include "core/discovery/pulse.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace sft::core {
namespace {

using ::testing::Optional;

const Pulse some{.node = 0x0102030405060708,
                 .participant = 0x11121314,
                 .digest_of_writers = 0x212223,
                 .digest_of_readers = 0x313233,
                 .full_signs = 0x41};

TEST(PulseTest, ComesAsItWasSent) { EXPECT_THAT(decode_pulse(encode(some)), Optional(some)); }

TEST(PulseTest, HasTheFormThatIsDocumented) {
  const auto version = static_cast<std::uint8_t>(control_protocol_version());
  const std::vector<std::uint8_t> expected = {'S',  'P',  version, 0x41, 0x23, 0x22, 0x21, 0x33,
                                              0x32, 0x31, 0x14,    0x13, 0x12, 0x11, 8,    7,
                                              6,    5,    4,       3,    2,    1};
  std::vector<std::uint8_t> written;
  for (const std::byte octet : encode(some)) written.push_back(static_cast<std::uint8_t>(octet));
  EXPECT_EQ(written, expected);
}

TEST(PulseTest, OfAnotherLengthIsNone) {
  const PulseDatagram datagram = encode(some);
  std::vector<std::byte> octets(datagram.begin(), datagram.end());
  for (std::size_t size = 0; size < octets.size(); ++size)
    EXPECT_FALSE(decode_pulse(std::span(octets).first(size))) << size;
  octets.push_back(std::byte{0});
  EXPECT_FALSE(decode_pulse(octets));
}

TEST(PulseTest, OfAnotherVersionOrKindIsNone) {
  for (std::size_t at = 0; at < 3; ++at) {
    PulseDatagram datagram = encode(some);
    datagram[at] ^= std::byte{1};
    EXPECT_FALSE(decode_pulse(datagram)) << at;
  }
}

}  // namespace
}  // namespace sft::core
