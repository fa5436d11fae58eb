#include "udp_transport/io/interfaces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

namespace sft::udp {
namespace {

using core::IpAddress;
using core::loopback_ipv4;
using core::loopback_ipv6;

std::vector<IpAddress> own_addresses(const std::vector<std::string>& chosen = {}) {
  std::vector<IpAddress> addresses;
  const std::vector<core::Link> links = own_links(chosen).value();
  for (const core::Link& link : links) addresses.push_back(link.ip);
  return addresses;
}

TEST(Interfaces, NameEachAddressOfTheHostOnce) {
  const auto addresses = own_addresses();
  ASSERT_FALSE(addresses.empty());
  EXPECT_EQ(std::set<IpAddress>(addresses.begin(), addresses.end()).size(), addresses.size());
}

TEST(Interfaces, NameLoopbackOnlyWhereThereIsNothingElse) {
  const auto addresses = own_addresses();
  const bool named = std::ranges::find(addresses, loopback_ipv4) != addresses.end();
  EXPECT_EQ(named, addresses.size() == 1 && addresses[0] == loopback_ipv4);
  EXPECT_EQ(std::ranges::find(addresses, loopback_ipv6), addresses.end());
}

TEST(Interfaces, AreThoseThatWereChosenByNameAddressOrNetwork) {
  for (const char* chosen : {"127.0.0.1", "127.0.0.0", "127.0.0.0/8", "127.0.0.0/30"}) {
    EXPECT_EQ(own_addresses({chosen}), std::vector<IpAddress>{loopback_ipv4}) << chosen;
  }
  EXPECT_EQ(own_addresses({"lo"}).front(), loopback_ipv4) << "maybe there is IPv6, too";
  for (const char* chosen : {"eth99", "127.0.0.2", "10.255.254.0/24", "fd99::/64"}) {
    EXPECT_TRUE(own_addresses({chosen}).empty()) << chosen << ", although there are others";
  }
}

TEST(Interfaces, AreChosenByWhatCanBeOne) {
  for (const char* chosen :
       {"eth0", "eth0.100", "eth0:1", "10.0.0.5", "10.0.0.0/24", "fd00::5", "fd00::/64", "fe80::1%eth99"})
    EXPECT_TRUE(check_interfaces({chosen})) << chosen;
  for (const char* chosen : {"", "10.0.0", "10.0.0.0/33", "fd00::/x", "fd00::12345", "a name", "eth0/24",
                             "fe80::1%", "fd00::1%eth99", "an-interface-with-a-long-name"}) {
    const Result<void> checked = check_interfaces({"eth0", chosen});
    ASSERT_FALSE(checked) << chosen;
    EXPECT_NE(checked.error().message.find("'" + std::string(chosen) + "'"), std::string::npos);
  }
}

TEST(Interfaces, TellTheNetworkOfAnAddress) {
  EXPECT_EQ(own_links({"127.0.0.1"}).value(), (std::vector<core::Link>{{loopback_ipv4, 8}}));
}

TEST(Interfaces, TellHowLongADatagramMayBe) {
  for (const IpAddress& to : {loopback_ipv4, loopback_ipv6}) {
    const std::size_t bytes = datagram_bytes_to({to, 9});
    EXPECT_GE(bytes, datagram_bytes_of_every_path(to));
    EXPECT_LE(bytes, datagram_bytes_max);
  }
}

TEST(Interfaces, AddressesComeBackFromTheSystemAsTheyWere) {
  IpAddress link_local = core::parse_ip_address("fe80::5").value();
  link_local.scope = 3;
  for (const IpAddress& ip : {loopback_ipv4, loopback_ipv6, link_local}) {
    for (const SystemAddress& address :
         {SystemAddress({ip, 7000}), SystemAddress::for_socket({ip, 7000}, AF_INET6)}) {
      sockaddr_in6 filled_in{};
      std::memcpy(&filled_in, address.get(), address.bytes());
      EXPECT_EQ(to_address(filled_in), (SocketAddress{ip, 7000})) << core::format(ip);
    }
  }
}

TEST(Interfaces, AreWirelessWhereTheirFolderSaysSo) {
  std::string folder = testing::TempDir() + "sft_interfaces_XXXXXX";
  ASSERT_NE(::mkdtemp(folder.data()), nullptr);
  for (const char* inside : {"eth0/statistics", "wlan0/phy80211", "wlan1/wireless"})
    std::filesystem::create_directories(folder + "/" + inside);
  EXPECT_FALSE(is_wireless("eth0", folder));
  EXPECT_TRUE(is_wireless("wlan0", folder));
  EXPECT_TRUE(is_wireless("wlan1", folder));
  EXPECT_FALSE(is_wireless("wlan2", folder)) << "it is not there";
  EXPECT_FALSE(is_wireless("lo"));
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace sft::udp
