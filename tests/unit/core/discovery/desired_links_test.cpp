// A table of hosts, each with the links that discovery should have on it.
#include "core/discovery/desired_links.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sft::core {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

HostInterface at(const std::string& name, const std::string& address, std::uint8_t bits = 24) {
  HostInterface interface;
  interface.name = name;
  interface.ip = parse_ip_address(address).value_or(IpAddress{});
  interface.prefix_bits = bits;
  interface.loopback = name == "lo";
  interface.multicast = name != "lo" && name != "wg0";
  return interface;
}
HostInterface down(HostInterface interface) {
  interface.up = interface.running = false;
  return interface;
}
HostInterface unplugged(HostInterface interface) {
  interface.running = false;
  return interface;
}

const HostInterface lo = at("lo", "127.0.0.1", 8);
const HostInterface eth0 = at("eth0", "10.0.0.5");
const HostInterface wlan0 = at("wlan0", "192.168.1.5");

struct Case {
  const char* name;
  std::vector<HostInterface> host;
  LinkRules rules;
  std::string links;
  std::string remarks;
  bool waits = false;
};

class DesiredLinksOf : public testing::TestWithParam<Case> {};

TEST_P(DesiredLinksOf, AreThese) {
  const DesiredLinks desired = desired_links(GetParam().host, GetParam().rules, {});
  std::string remarks;
  for (const std::string& remark : desired.remarks) remarks += (remarks.empty() ? "" : "; ") + remark;
  EXPECT_EQ(describe(desired.links), GetParam().links);
  EXPECT_EQ(remarks, GetParam().remarks);
  EXPECT_EQ(desired.waits_for_network, GetParam().waits);
}

INSTANTIATE_TEST_SUITE_P(
    Hosts, DesiredLinksOf,
    testing::Values(
        Case{"OneCard", {lo, eth0}, {}, "lo, eth0 (10.0.0.5)", ""},
        Case{"TwoCards", {lo, eth0, wlan0}, {}, "lo, eth0 (10.0.0.5), wlan0 (192.168.1.5)", ""},
        Case{"NoCardYet", {lo}, {}, "lo", "", true},
        Case{"CardWithoutAddress", {lo, at("eth0", "")}, {}, "lo", "", true},
        Case{"CardWithoutMulticast",
             {lo, at("wg0", "10.0.0.5"), at("docker0", "172.17.0.1")},
             {},
             "lo",
             "wg0 (10.0.0.5) is left out, since it has no multicast: ip link set dev wg0 multicast on, or "
             "name "
             "the hosts beyond it as peers, on both sides",
             true},
        Case{"CardThatIsDown", {lo, down(eth0)}, {}, "lo", "", true},
        Case{"CardWithoutCarrier", {lo, unplugged(eth0)}, {}, "lo, eth0 (10.0.0.5)", ""},
        Case{"NothingUp", {down(lo), down(eth0)}, {}, "", "", true},
        Case{"LoopbackDown", {down(lo), eth0}, {}, "eth0 (10.0.0.5)", ""},
        Case{"Listed", {lo, eth0, wlan0}, {.listed = {"wlan0"}}, "lo, wlan0 (192.168.1.5)", ""},
        Case{"ListedWithLo", {lo, eth0, wlan0}, {.listed = {"lo", "wlan0"}}, "lo, wlan0 (192.168.1.5)", ""},
        Case{"ListedReversed", {lo, eth0}, {.listed = {"eth0", "lo"}}, "lo, eth0 (10.0.0.5)", ""},
        Case{"ListedByAddress", {lo, eth0, wlan0}, {.listed = {"10.0.0.5"}}, "lo, eth0 (10.0.0.5)", ""},
        Case{"ListedByNetwork",
             {lo, eth0, wlan0},
             {.listed = {"192.168.0.0/16"}},
             "lo, wlan0 (192.168.1.5)",
             ""},
        Case{"ListedWithTypo",
             {lo, eth0},
             {.listed = {"ehh0", "eth0"}},
             "lo, eth0 (10.0.0.5)",
             "ehh0 is not there"},
        Case{"ListedAndNotThere", {lo, eth0}, {.listed = {"eth9"}}, "lo", "eth9 is not there", true},
        Case{"ListedAndDown", {lo, down(eth0)}, {.listed = {"eth0"}}, "lo", "eth0 is down", true},
        Case{"ListedWithoutAddress",
             {lo, at("eth0", "")},
             {.listed = {"eth0"}},
             "lo",
             "eth0 has no address of use",
             true},
        Case{"OnlyLoListed", {lo, eth0}, {.listed = {"lo"}}, "lo", ""},
        Case{"Containers",
             {lo, eth0, at("docker0", "172.17.0.1", 16), at("veth12ab", "10.1.0.1"),
              at("virbr0", "192.168.122.1")},
             {},
             "lo, eth0 (10.0.0.5)",
             ""},
        Case{"ContainersThatAreListed",
             {lo, eth0, at("docker0", "172.17.0.1", 16)},
             {.listed = {"docker0"}},
             "lo, docker0 (172.17.0.1)",
             ""},
        Case{"TunnelWithoutMulticast", {lo, eth0, at("wg0", "10.8.0.2")}, {}, "lo, eth0 (10.0.0.5)", ""},
        Case{"TunnelWithPeers",
             {lo, eth0, at("wg0", "10.8.0.2")},
             {.peers = true},
             "lo, eth0 (10.0.0.5), wg0 (10.8.0.2)",
             ""},
        Case{"TwoAddressesInOneNetwork", {lo, eth0, at("eth0", "10.0.0.6")}, {}, "lo, eth0 (10.0.0.5)", ""},
        Case{"TwoNetworksOnOneCard",
             {lo, eth0, at("eth0", "10.1.0.6")},
             {},
             "lo, eth0 (10.0.0.5), eth0 (10.1.0.6)",
             ""},
        Case{"TwoCardsInOneNetwork",
             {lo, eth0, at("eth1", "10.0.0.6")},
             {},
             "lo, eth0 (10.0.0.5), eth1 (10.0.0.6)",
             ""},
        Case{"OnlyIPv6",
             {lo, at("eth0", "fd00::5", 64), at("eth0", "fe80::5", 64)},
             {},
             "lo, eth0 (IPv6)",
             ""},
        Case{"BothFamilies", {lo, eth0, at("eth0", "fd00::5", 64)}, {}, "lo, eth0 (10.0.0.5)", ""},
        Case{"OnThisHostOnly", {lo}, {.multicast = false}, "lo", ""}),
    [](const auto& param) { return param.param.name; });

TEST(DesiredLinks, StayWhileTheirInterfaceIsDownAndGoWithTheirAddress) {
  const std::vector<LinkSpec> before = desired_links(std::vector{lo, eth0}, {}, {}).links;
  const DesiredLinks desired = desired_links(std::vector{lo, down(eth0)}, {}, before);
  EXPECT_EQ(desired.links, before);
  EXPECT_FALSE(desired.waits_for_network);
  EXPECT_EQ(describe(desired_links(std::vector{lo, at("eth0", "10.0.0.9")}, {}, before).links),
            "lo, eth0 (10.0.0.9)");
}

TEST(DesiredLinks, AreMadeAnewWhereTheInterfaceWasReplacedAndHasItsAddress) {
  const std::vector<LinkSpec> before = desired_links(std::vector{lo, eth0}, {}, {}).links;
  HostInterface another = eth0;
  another.index = 9;
  EXPECT_NE(desired_links(std::vector{lo, another}, {}, before).links, before);
}

TEST(DesiredLinks, StayAtTheAddressInUseWhereAnotherOneOfItsNetworkIsListedBeforeIt) {
  const std::vector<LinkSpec> before = desired_links(std::vector{lo, eth0}, {}, {}).links;
  EXPECT_EQ(desired_links(std::vector{lo, at("eth0", "10.0.0.4"), eth0}, {}, before).links, before);
}

TEST(DesiredLinks, AreNotMoreThanTheLimitAndThoseInUseStay) {
  std::vector<HostInterface> host{lo};
  for (int i = 0; i < 9; ++i)
    host.push_back(at("eth" + std::to_string(i), "10.0." + std::to_string(i) + ".5"));
  const DesiredLinks desired = desired_links(host, {}, {});
  EXPECT_EQ(desired.links.size(), links_max);
  EXPECT_THAT(desired.remarks, ElementsAre(HasSubstr("eth7 is left out"), HasSubstr("eth8 is left out")));
  const std::vector<LinkSpec> in_force{desired.links[0], {"eth8", host[9].ip, 24, false, false, 0}};
  EXPECT_THAT(describe(desired_links(host, {}, in_force).links), HasSubstr("eth8 (10.0.8.5)"));
}

TEST(DesiredLinks, ReachTheirOwnHostOnlyWhereThereIsNoLoopback) {
  EXPECT_FALSE(desired_links(std::vector{lo, eth0}, {}, {}).links.at(1).reaches_own_host);
  EXPECT_TRUE(desired_links(std::vector{down(lo), eth0}, {}, {}).links.at(0).reaches_own_host);
}

}  // namespace
}  // namespace sft::core
