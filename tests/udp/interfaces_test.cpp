#include "udp_transport/interfaces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "udp_transport/datagram.h"

namespace sft::udp {
namespace {

constexpr std::uint32_t loopback = 0x7f000001;

TEST(Interfaces, NameEachAddressOfTheHostOnce) {
  const auto addresses = own_addresses();
  ASSERT_FALSE(addresses.empty());
  EXPECT_EQ(std::set<std::uint32_t>(addresses.begin(), addresses.end()).size(), addresses.size());
}

TEST(Interfaces, NameLoopbackOnlyWhereThereIsNothingElse) {
  const auto addresses = own_addresses();
  const bool named = std::find(addresses.begin(), addresses.end(), loopback) != addresses.end();
  EXPECT_EQ(named, addresses.size() == 1 && addresses[0] == loopback);
}

TEST(Interfaces, TellHowLongADatagramMayBe) {
  const std::size_t bytes = datagram_bytes_to({loopback, 9});
  EXPECT_GE(bytes, datagram_bytes_min);
  EXPECT_LE(bytes, datagram_bytes_max);
}

TEST(Interfaces, FormatAddresses) { EXPECT_EQ(format_ipv4(0x0a630102), "10.99.1.2"); }

}  // namespace
}  // namespace sft::udp
