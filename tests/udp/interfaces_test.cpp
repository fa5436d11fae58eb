#include "udp_transport/interfaces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "udp_transport/datagram.h"

namespace sft::udp {
namespace {

constexpr std::uint32_t loopback = 0x7f000001;

std::vector<std::uint32_t> own_addresses(const std::vector<std::string>& chosen = {}) {
  std::vector<std::uint32_t> addresses;
  for (const core::Link& link : own_links(chosen)) addresses.push_back(link.ipv4);
  return addresses;
}

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

TEST(Interfaces, AreThoseThatWereChosenByNameAddressOrNetwork) {
  for (const char* chosen : {"lo", "127.0.0.1", "127.0.0.0"}) {
    EXPECT_EQ(own_addresses({chosen}), std::vector<std::uint32_t>{loopback}) << chosen;
  }
  EXPECT_TRUE(own_addresses({"eth99"}).empty()) << "although there are others";
}

TEST(Interfaces, TellTheNetworkOfAnAddress) {
  EXPECT_EQ(own_links({"lo"}), (std::vector<core::Link>{{loopback, 0xff000000}}));
}

TEST(Interfaces, TellHowLongADatagramMayBe) {
  const std::size_t bytes = datagram_bytes_to({loopback, 9});
  EXPECT_GE(bytes, datagram_bytes_min);
  EXPECT_LE(bytes, datagram_bytes_max);
}

TEST(Interfaces, FormatAddresses) { EXPECT_EQ(format_ipv4(0x0a630102), "10.99.1.2"); }

}  // namespace
}  // namespace sft::udp
