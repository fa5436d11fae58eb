#include "udp_transport/wire/keyed_hash.h"

#include <gtest/gtest.h>

namespace sft::udp {
namespace {

/// The key and the messages are those of the SipHash paper's reference implementation, read as
/// little-endian words.
TEST(KeyedHashTest, IsSipHash) {
  constexpr HashKey key{0x0706050403020100, 0x0f0e0d0c0b0a0908};
  constexpr std::array<std::uint64_t, 1> eight_bytes{0x0706050403020100};
  EXPECT_EQ(keyed_hash(key, {}), 0x726fdb47dd0e0e31U);
  EXPECT_EQ(keyed_hash(key, eight_bytes), 0x93f5f5799a932462U);
}

}  // namespace
}  // namespace sft::udp
