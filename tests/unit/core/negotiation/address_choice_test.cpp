#include "core/negotiation/local_host.h"

#include <gtest/gtest.h>

#include <vector>

namespace sft::core {
namespace {

UdpAddress address(const char* text, bool wireless = false) {
  return {parse_ip_address(text).value(), 7000, 1, wireless};
}
Link link(const char* text, bool wireless = false) {
  const IpNetwork network = parse_ip_network(text).value();
  return {network.ip, static_cast<std::uint8_t>(network.prefix_bits.value()), true, wireless};
}
Link without_carrier(Link link) {
  link.running = false;
  return link;
}

const UdpAddress wired = address("192.168.1.5"), wireless = address("10.0.0.5", true);
const UdpAddress bridge = address("172.17.0.1"), ipv6 = address("fd00::5"), link_local = address("fe80::5");
const Link our_wired = link("192.168.1.4/24"), our_wireless = link("10.0.0.4/24", true);
const Link our_bridge = link("172.17.0.1/16"), our_ipv6 = link("fd00::4/64");

UdpAddress choose(std::vector<UdpAddress> of_reader, std::vector<Link> ours) {
  return choose_address(of_reader, ours);
}

TEST(AddressChoice, IsTheOneInANetworkThatWeAreInToo) {
  EXPECT_EQ(choose({wired, wireless}, {our_wireless}), wireless);
  EXPECT_EQ(choose({wired, wireless}, {our_bridge, our_wireless}), wireless);
  EXPECT_EQ(choose({wired, ipv6}, {our_wireless, our_ipv6}), ipv6);
}

TEST(AddressChoice, IsByWireRatherThanByRadio) {
  EXPECT_EQ(choose({wireless, wired}, {our_wireless, our_wired}), wired);
  EXPECT_EQ(choose({address("10.0.0.5"), wired}, {our_wireless, our_wired}), wired) << "ours is by radio";
  EXPECT_EQ(choose({address("192.168.1.6", true), wired}, {our_wired}), wired) << "theirs is by radio";
}

TEST(AddressChoice, IsTheBestForTheReaderIfSeveralAreEquallyNear) {
  EXPECT_EQ(choose({wired, ipv6}, {our_ipv6, our_wired}), wired);
  EXPECT_EQ(choose({ipv6, wired}, {our_ipv6, our_wired}), ipv6);
}

TEST(AddressChoice, IsTheFirstIfRoutesHaveToLeadThere) {
  EXPECT_EQ(choose({wired, wireless}, {link("192.168.2.4/24")}), wired);
  EXPECT_EQ(choose({wired, wireless}, {}), wired);
}

TEST(AddressChoice, IsOfAFamilyThatWeHave) {
  EXPECT_EQ(choose({ipv6, address("192.168.9.5")}, {our_wired}), address("192.168.9.5"));
  EXPECT_EQ(choose({wired, address("fd09::5")}, {our_ipv6, link("fe80::4/64")}), address("fd09::5"));
}

TEST(AddressChoice, IsNotBehindAnInterfaceWithoutCarrier) {
  EXPECT_EQ(choose({wired, wireless}, {our_wireless, without_carrier(our_wired)}), wireless);
  EXPECT_EQ(choose({wired, ipv6}, {without_carrier(our_wired), link("fd01::4/64")}), ipv6)
      << "routes may lead there";
  EXPECT_EQ(choose({wired}, {without_carrier(our_wired)}), wired) << "there is no other";
  EXPECT_EQ(choose({wired, wireless}, {our_wireless, without_carrier(our_wired), our_wired}), wired)
      << "there are two interfaces to that network";
}

TEST(AddressChoice, IsNotAnAddressThatWeHaveOurselves) {
  EXPECT_EQ(choose({bridge, wired}, {our_bridge}), wired);
  EXPECT_EQ(choose({bridge, wired}, {our_bridge, our_wired}), wired);
  EXPECT_EQ(choose({bridge}, {our_bridge}), bridge) << "there is no other";
}

/// A link-local address does not show to which link it belongs. So such an address is chosen only if there
/// is no other choice.
TEST(AddressChoice, IsLinkLocalOnlyForWantOfOthersAndThenByAnInterfaceOfOurs) {
  Link ours = link("fe80::4/64");
  ours.ip.scope = 3;
  UdpAddress by_ours = link_local;
  by_ours.ip.scope = 3;
  EXPECT_EQ(choose({link_local, wired}, {ours, link("10.9.0.4/24")}), wired) << "routes may lead there";
  EXPECT_EQ(choose({link_local}, {ours}), by_ours);
  Link dead = without_carrier(ours);
  dead.ip.scope = 2;
  EXPECT_EQ(choose({link_local}, {dead, ours}), by_ours);
}

}  // namespace
}  // namespace sft::core
