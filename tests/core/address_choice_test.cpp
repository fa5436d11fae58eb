#include "core/address_choice.h"

#include <gtest/gtest.h>

#include <vector>

namespace sft::core {
namespace {

constexpr std::uint32_t ipv4(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
  return a << 24 | b << 16 | c << 8 | d;
}
constexpr std::uint32_t slash_24 = 0xffffff00, slash_16 = 0xffff0000;

constexpr UdpAddress wired{ipv4(192, 168, 1, 5), 7000, 1};
constexpr UdpAddress wireless{ipv4(10, 0, 0, 5), 7000, 1};
constexpr UdpAddress bridge{ipv4(172, 17, 0, 1), 7000, 1};
constexpr Link our_wired{ipv4(192, 168, 1, 4), slash_24};
constexpr Link our_wireless{ipv4(10, 0, 0, 4), slash_24};
constexpr Link our_bridge{ipv4(172, 17, 0, 1), slash_16};

UdpAddress choose(std::vector<UdpAddress> of_reader, std::vector<Link> ours) {
  return choose_address(of_reader, ours);
}

TEST(AddressChoice, IsTheOneInANetworkThatWeAreInToo) {
  EXPECT_EQ(choose({wired, wireless}, {our_wireless}), wireless);
  EXPECT_EQ(choose({wired, wireless}, {our_bridge, our_wireless}), wireless);
}

TEST(AddressChoice, IsTheBestForTheReaderIfSeveralAreNear) {
  EXPECT_EQ(choose({wired, wireless}, {our_wireless, our_wired}), wired);
  EXPECT_EQ(choose({wireless, wired}, {our_wireless, our_wired}), wireless);
}

TEST(AddressChoice, IsTheFirstIfRoutesHaveToLeadThere) {
  EXPECT_EQ(choose({wired, wireless}, {{ipv4(192, 168, 2, 4), slash_24}}), wired);
  EXPECT_EQ(choose({wired, wireless}, {}), wired);
}

TEST(AddressChoice, IsNotAnAddressThatWeHaveOurselves) {
  EXPECT_EQ(choose({bridge, wired}, {our_bridge}), wired);
  EXPECT_EQ(choose({bridge, wired}, {our_bridge, our_wired}), wired);
  EXPECT_EQ(choose({bridge}, {our_bridge}), bridge) << "there is no other";
}

}  // namespace
}  // namespace sft::core
