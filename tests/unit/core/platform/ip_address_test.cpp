#include "core/platform/ip_address.h"

#include <gtest/gtest.h>

namespace sft::core {
namespace {

IpAddress parsed(std::string_view text) { return parse_ip_address(text).value(); }

TEST(IpAddressTest, ComesBackFromTextAsItWas) {
  for (const char* text : {"10.99.1.2", "0.0.0.1", "255.255.255.255", "fd00::7", "::1", "::", "fe80::1%lo"})
    EXPECT_EQ(format(parsed(text)), text);
  EXPECT_EQ(parsed("10.99.1.2").ipv4(), 0x0a630102U);
  EXPECT_EQ(parsed("127.0.0.1"), loopback_ipv4);
  EXPECT_EQ(parsed("::1"), loopback_ipv6);
  EXPECT_EQ(parsed("fe80::1%1"), parsed("fe80::1%lo")) << "an interface has a number, too";
}

TEST(IpAddressTest, HasItsPortBehindIt) {
  EXPECT_EQ(format(parsed("10.99.1.2"), 7000), "10.99.1.2:7000");
  EXPECT_EQ(format(parsed("fd00::7"), 7000), "[fd00::7]:7000");
  EXPECT_EQ(format(parsed("fe80::1%lo"), 7000), "[fe80::1%lo]:7000");
}

TEST(IpAddressTest, IsOfIPv4InBothSpellings) {
  EXPECT_EQ(parsed("::ffff:10.0.0.1"), parsed("10.0.0.1"));
  EXPECT_TRUE(parsed("::ffff:10.0.0.1").is_ipv4());
  EXPECT_FALSE(parsed("::10.0.0.1").is_ipv4());
}

TEST(IpAddressTest, IsNothingElse) {
  for (const char* text :
       {"", "10.0.0", "10.0.0.256", "eth0", "fd00:::1", "fd00::12345", "10.0.0.1%lo", "fd00::1%lo",
        "fe80::1%", "fe80::1%no-such-device", "[::1]", " ::1", "10.0.0.0/8"}) {
    EXPECT_FALSE(parse_ip_address(text)) << text;
  }
}

TEST(IpNetworkTest, SaysHowManyBitsItHas) {
  EXPECT_EQ(parse_ip_network("10.0.0.0/24"), (IpNetwork{parsed("10.0.0.0"), 24}));
  EXPECT_EQ(parse_ip_network("fd00::/64"), (IpNetwork{parsed("fd00::"), 64}));
  EXPECT_EQ(parse_ip_network("10.0.0.1"), (IpNetwork{parsed("10.0.0.1"), {}}));
  for (const char* text :
       {"10.0.0.0/33", "fd00::/129", "10.0.0.0/", "10.0.0.0/x", "10.0.0.0/-1", "/8", "eth0/8"})
    EXPECT_FALSE(parse_ip_network(text)) << text;
}

TEST(IpNetworkTest, HoldsTheAddressesOfItsFamilyThatBeginLikeIt) {
  const auto holds = [](const char* a, const char* b, unsigned bits) {
    return in_one_network(parsed(a), parsed(b), bits);
  };
  EXPECT_TRUE(holds("10.0.0.1", "10.0.0.254", 24));
  EXPECT_FALSE(holds("10.0.0.1", "10.0.1.1", 24));
  EXPECT_TRUE(holds("10.0.2.1", "10.0.3.1", 23));
  EXPECT_FALSE(holds("10.0.1.1", "10.0.2.1", 23));
  EXPECT_TRUE(holds("10.0.0.1", "192.168.0.1", 0));
  EXPECT_FALSE(holds("10.0.0.1", "fd00::1", 0));
  EXPECT_TRUE(holds("fd00::1", "fd00::ffff", 64));
  EXPECT_FALSE(holds("fd00::1", "fd00:0:0:1::1", 64));
  EXPECT_FALSE(holds("fd00::1", "fd00::2", 128));
}

TEST(IpNetworkTest, OfLinksThatAreNotTheSameAreNotTheSame) {
  IpAddress here = parsed("fe80::1"), there = parsed("fe80::2");
  EXPECT_TRUE(in_one_network(here, there, 64)) << "as far as is known";
  here.scope = 1;
  EXPECT_TRUE(in_one_network(here, there, 64));
  there.scope = 2;
  EXPECT_FALSE(in_one_network(here, there, 64));
}

TEST(IpNetworkTest, IsItsAddressesWithoutWhatTellsThemApart) {
  EXPECT_EQ(network_of(parsed("10.1.2.3"), 23), parsed("10.1.2.0"));
  EXPECT_EQ(network_of(parsed("fd00::1:2:3:4"), 64), parsed("fd00::"));
  EXPECT_EQ(network_of(parsed("fd00::1"), 128), parsed("fd00::1"));
}

}  // namespace
}  // namespace sft::core
