// The order of settings: first SFT's defaults, then the user's settings, then the settings that SFT
// requires. The log warns about settings of the user that have disadvantages.
#include "core/discovery/dds_config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/discovery/cyclone_settings.h"

namespace sft::core {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Optional;

DdsConfig config(const std::string& user, const DiscoverySettings& settings = {}) {
  return dds_config(0, settings, user).value();
}

const LinkSpec loopback{"lo", loopback_ipv4, 8, true, true, 1};
const LinkSpec card{"eth0", IpAddress(0x0A000005), 24, false, false, 2};

const KnownHosts hosts{{"a", {IpAddress(0x0A000001)}}, {"robot.local", {IpAddress(0x0A000008)}}};

/// Returns the settings that are finally in force in Cyclone for the link.
CycloneSettings heard(const DdsConfig& config, const LinkSpec& link = loopback) {
  return CycloneSettings::read(config.text_for(link, hosts), 0).value();
}
std::optional<std::string> in_force(const DdsConfig& config, std::string_view path,
                                    const LinkSpec& link = loopback) {
  return heard(config, link).value(path);
}
auto is(const char* value) { return Optional(std::string(value)); }

TEST(DdsConfig, OfTheUserWinsOverOurs) {
  const auto plain = config("");
  const auto theirs = config("<Discovery><LeaseDuration>77 s</></>,<Internal><NackDelay>5 ms</></>");
  EXPECT_NE(in_force(plain, "Discovery/LeaseDuration"), std::nullopt);
  EXPECT_THAT(in_force(theirs, "Discovery/LeaseDuration"), is("77 s"));
  EXPECT_THAT(in_force(theirs, "Internal/NackDelay"), is("5 ms"));
  EXPECT_THAT(plain.warnings, IsEmpty());
  EXPECT_THAT(theirs.warnings, IsEmpty());
}

/// Without the delay, each of N readers would answer each heartbeat that is repeated for one of N new
/// readers.
TEST(DdsConfig, AReaderThatHasSaidThatItMissesNothingWaitsBeforeItSaysSoAgain) {
  EXPECT_THAT(in_force(config(""), "Internal/AckDelay"), is("1 s"));
  EXPECT_THAT(in_force(config("<Internal><AckDelay>10 ms</></>"), "Internal/AckDelay"), is("10 ms"));
}

TEST(DdsConfig, ReceiveBuffersAreSmallUnlessTheUserWantsOthers) {
  EXPECT_THAT(in_force(config(""), "Sizing/ReceiveBufferSize"), is("256 KiB"));
  EXPECT_THAT(in_force(config("<Sizing><ReceiveBufferSize>2 MiB</></>"), "Sizing/ReceiveBufferSize"),
              is("2 MiB"));
}

TEST(DdsConfig, OfTheUserDoesNotHoldWhereItWouldBreakSft) {
  EXPECT_THAT(in_force(config("<SharedMemory><Enable>true</></>"), "SharedMemory/Enable"), is("false"));
  EXPECT_THAT(
      in_force(config("<General><EnableMulticastLoopback>false</></>"), "General/EnableMulticastLoopback"),
      is("true"));
  EXPECT_THAT(in_force(config("<Compatibility><ManySocketsMode>none</></>"), "Compatibility/ManySocketsMode"),
              is("single"));
  constexpr const char* without_port = "<Discovery><ParticipantIndex>none</></>";
  EXPECT_THAT(in_force(config(without_port), "Discovery/ParticipantIndex"), is("none"));
  EXPECT_THAT(in_force(config(std::string("<General><AllowMulticast>false</></>") + without_port),
                       "Discovery/ParticipantIndex"),
              is("auto"));
}

TEST(DdsConfig, OfAnotherDomainIsSaidNotToHold) {
  EXPECT_THAT(config("<Domain Id='5'><Discovery><LeaseDuration>77 s</></></>").warnings,
              ElementsAre(HasSubstr("only for others")));
}

TEST(DdsConfig, SaysWhatDdsSecurityDoesNotProtect) {
  EXPECT_THAT(config("<Security><Authentication><IdentityCA>file:ca.pem</></></>").warnings,
              ElementsAre(HasSubstr("not the samples")));
}

TEST(DdsConfig, OfTheUserIsPassedThroughAsItIsWhereThatSuffices) {
  for (const std::string user :
       {"<General><FragmentSize>100 B</></>", "<Domain id='any'><Tracing><Verbosity>fine</></></>",
        "<Partitioning/>, <Security><Authentication/>"})
    EXPECT_THAT(config(user).text, HasSubstr("," + user + ",")) << user;
  for (const std::string user :
       {"<General><NetworkInterfaceAddress>eth0</></>", "<Discovery><ExternalDomainId>3</></>",
        "<Domain Id='0'><Tracing><Verbosity>fine</></></>", "<Discovery><Peers><Peer Address='a'/></></>"})
    EXPECT_THAT(config(user).text, testing::Not(HasSubstr(user))) << user;
}

TEST(DdsConfig, LetsCycloneAnnounceItselfSeldomAndMoreSeldomToPeers) {
  EXPECT_THAT(in_force(config(""), "Discovery/LeaseDuration"), is("40000 ms"));
  EXPECT_THAT(in_force(config(""), "Discovery/SPDPInterval"), is("30000 ms"));
  for (const auto& c : {config("", {.peers = {"a"}}), config("", {.multicast = false})}) {
    EXPECT_THAT(in_force(c, "Discovery/LeaseDuration"), is("160000 ms"));
    EXPECT_THAT(in_force(c, "Discovery/SPDPInterval"), is("120000 ms"));
  }
}

/// Linux delivers a multicast datagram to all sockets that are bound to its port, whatever their
/// interfaces.
TEST(DdsConfig, GivesMulticastsOfTheLoopbackPortsOfTheirOwnSoThatTheyDoNotWakeTheOtherLinks) {
  const auto c = config("");
  EXPECT_THAT(in_force(c, "Discovery/Ports/MulticastMetaOffset", loopback), is("2"));
  EXPECT_THAT(in_force(c, "Discovery/Ports/MulticastDataOffset", loopback), is("3"));
  EXPECT_EQ(in_force(c, "Discovery/Ports/MulticastMetaOffset", card), std::nullopt);
  EXPECT_EQ(in_force(c, "Discovery/Ports/MulticastDataOffset", card), std::nullopt);
}

TEST(DdsConfig, GivesHeartbeatsAPortThatDdsLeavesUnused) {
  EXPECT_EQ(config("").heartbeat_port, 7404);
  EXPECT_EQ(config("<Discovery><ExternalDomainId>3</></>").heartbeat_port, 8154)
      << "that of the domain on the wire";
  EXPECT_EQ(dds_config(232, {}, "").value().heartbeat_port, 65'404);
  EXPECT_EQ(config("<General><AllowMulticast>true</></>").heartbeat_port, 7404);
}

TEST(DdsConfig, SendsNoHeartbeatsByUdpWhereTheyMightNotArriveOrWhereNodesHaveCertificates) {
  for (const char* user :
       {"<General><AllowMulticast>false</></>", "<General><AllowMulticast>spdp</></>",
        "<General><AllowMulticast>ssm</></>", "<General><MulticastTimeToLive>1</></>",
        "<Discovery><SPDPMulticastAddress>239.255.0.7</></>", "<Discovery><Ports><Base>7500</></></>",
        "<Discovery><Tag>left</></>", "<Security><Authentication><IdentityCertificate>file:a</></></>"})
    EXPECT_EQ(config(user).heartbeat_port, std::nullopt) << user;
  EXPECT_EQ(config("", {.multicast = false}).heartbeat_port, std::nullopt);
  EXPECT_EQ(config("", {.peers = {"10.0.0.7"}}).heartbeat_port, std::nullopt);
}

TEST(DdsConfig, WithPeersPutsNodesAtPortsThatCanBeGuessed) {
  const auto c = config("", {.peers = {"10.0.0.7", "robot.local"}});
  EXPECT_THAT(in_force(c, "Discovery/ParticipantIndex"), is("auto"));
  EXPECT_THAT(heard(c, card).values("Discovery/Peers/Peer/@Address"), ElementsAre("10.0.0.7", "10.0.0.8"));
  EXPECT_THAT(heard(c, loopback).values("Discovery/Peers/Peer/@Address"), IsEmpty())
      << "nobody is reached by it";
  EXPECT_EQ(in_force(c, "General/DontRoute", card), std::nullopt) << "they may be behind a router";
  EXPECT_THAT(in_force(config(""), "General/DontRoute", card), is("true"));
  EXPECT_THAT(in_force(c, "General/AllowMulticast"), is("spdp")) << "what follows might not reach them";
  EXPECT_EQ(c.summary(std::vector{loopback, card}),
            "by multicast on lo, eth0 (10.0.0.5), and on the peers 10.0.0.7, robot.local");
  EXPECT_EQ(in_force(config(""), "Discovery/ParticipantIndex"), std::nullopt)
      << "that limits how many there can be";
  EXPECT_THAT(in_force(config("<Discovery><Peers><Peer Address='a'/></></>"), "Discovery/ParticipantIndex"),
              is("auto"));
}

TEST(DdsConfig, WithoutMulticastFindsNodesOfThisHostAllTheSame) {
  for (const auto& c :
       {config("", {.peers = {"a"}, .multicast = false}),
        config("<General><AllowMulticast>false</></><Discovery><Peers><Peer Address='a'/></></>")}) {
    EXPECT_THAT(heard(c, loopback).values("Discovery/Peers/Peer/@Address"), testing::Contains("127.0.0.1"));
    EXPECT_THAT(heard(c, card).values("Discovery/Peers/Peer/@Address"), ElementsAre("10.0.0.1"));
    EXPECT_THAT(in_force(c, "General/AllowMulticast"), is("false"));
    EXPECT_THAT(in_force(c, "Discovery/ParticipantIndex"), is("auto"));
    EXPECT_THAT(c.warnings, IsEmpty());
    EXPECT_EQ(c.summary(std::vector{loopback}), "on this host, and on the peers a, by lo");
  }
  EXPECT_THAT(config("", {.multicast = false}).warnings, ElementsAre(HasSubstr("only nodes of this host")));
}

/// Cyclone gets no names of hosts, because it would look them up on the thread that opens a link.
TEST(DdsConfig, HasNumbersOnlyForPeersByNameOfTheSettingsAndOfTheUser) {
  const DiscoverySettings settings{.peers = {"robot.local:7410", "nobody.local"}};
  const char* user =
      "<Discovery><Peers><Peer Address='a,10.0.0.9'/></><LeaseDuration>77 s</></><Internal><NackDelay>6 s";
  const auto c = config(user, settings);
  EXPECT_THAT(heard(c, card).values("Discovery/Peers/Peer/@Address"),
              ElementsAre("10.0.0.8:7410", "10.0.0.1", "10.0.0.9"));
  EXPECT_THAT(in_force(c, "Discovery/LeaseDuration"), is("77 s"));
  EXPECT_THAT(in_force(c, "Internal/NackDelay"), is("6 s"));
  EXPECT_EQ(c.family_of_peers(std::vector{loopback, card}), IpFamily::ipv4);
  EXPECT_EQ(config("", settings).family_of_peers(std::vector{loopback}), std::nullopt) << "no peer is asked";
}

TEST(DdsConfig, GivesEachLinkItsAddressAndTheUsersOfThemNone) {
  const DiscoverySettings settings{.interfaces = {"eth1", "10.0.0.1", "10.1.0.0/16"}};
  const char* user =
      "<General><Interfaces><NetworkInterface name='wlan0' priority='2'/></><FragmentSize>2 kB</></>";
  EXPECT_THAT(config("", settings).interfaces, ElementsAre("eth1", "10.0.0.1", "10.1.0.0/16"));
  const auto theirs = config(user, settings);
  EXPECT_THAT(theirs.interfaces, ElementsAre("wlan0"));
  EXPECT_THAT(theirs.warnings, ElementsAre(HasSubstr("CYCLONEDDS_URI chooses the network interfaces")));
  const CycloneSettings in_the_end = heard(theirs, card);
  EXPECT_THAT(in_the_end.values("General/Interfaces/NetworkInterface/@name"), IsEmpty());
  EXPECT_THAT(in_the_end.values("General/Interfaces/NetworkInterface/@address"), ElementsAre("10.0.0.5"));
  EXPECT_THAT(in_the_end.value("General/FragmentSize"), is("2 kB"));
  EXPECT_THAT(
      heard(theirs, {"eth0", {}, 0, false, false, 2}).values("General/Interfaces/NetworkInterface/@name"),
      ElementsAre("eth0"));
}

TEST(DdsConfig, TakesInterfacesThatCycloneIsToChooseForAll) {
  EXPECT_THAT(config("<General><Interfaces><NetworkInterface autodetermine='true'/></></>").interfaces,
              IsEmpty());
  EXPECT_THAT(config("<General><NetworkInterfaceAddress>auto</></>").interfaces, IsEmpty());
}

TEST(DdsConfig, OfADomainHoldsForItsLinksWhateverTheirNumbersInTheProcess) {
  const auto c = dds_config(5, {},
                            "<Domain Id='5'><Discovery><LeaseDuration>77 s</></></><Domain "
                            "Id='6'><Internal><NackDelay>6 s</></></>");
  const auto in_the_end = CycloneSettings::read(c->text_for(card), 1001).value();
  EXPECT_THAT(in_the_end.value("Discovery/LeaseDuration"), is("77 s"));
  EXPECT_THAT(in_the_end.value("Internal/NackDelay"), is("1 ms"));
  EXPECT_THAT(in_the_end.value("Discovery/ExternalDomainId"), is("5"));
}

TEST(DdsConfig, LetsNodesOfOneHostMeetOnTheLoopbackAlone) {
  EXPECT_THAT(in_force(config(""), "General/EnableMulticastLoopback", loopback), is("true"));
  EXPECT_THAT(in_force(config(""), "General/EnableMulticastLoopback", card), is("false"));
  EXPECT_THAT(in_force(config(""), "General/EnableMulticastLoopback", {"eth0", card.ip, 24, false, true, 2}),
              is("true"));
}

TEST(DdsConfig, TellsTheInterfacesForSamplesToo) {
  const DiscoverySettings settings{.interfaces = {"eth1"}};
  EXPECT_THAT(discovery_interfaces(0, settings, "").value(), ElementsAre("eth1"));
  EXPECT_THAT(
      discovery_interfaces(0, settings, "<General><Interfaces><NetworkInterface address='10.0.0.1'/></></>")
          .value(),
      ElementsAre("10.0.0.1"));
  EXPECT_THAT(discovery_interfaces(0, {}, "<General><NetworkInterfaceAddress>eth0,wlan0</></>").value(),
              ElementsAre("eth0", "wlan0"));
}

TEST(DdsConfig, TakesNoNamesThatWouldBeConfiguration) {
  for (const char* name : {"", "a b", "\"/><Peer Address=\"b", "a,b", "${HOME}", "a&amp;"}) {
    EXPECT_FALSE(dds_config(0, {.peers = {name}}, "")) << name;
    EXPECT_FALSE(dds_config(0, {.interfaces = {name}}, "")) << name;
  }
  EXPECT_THAT(dds_config(0, {.peers = {"a b"}}, "").error().message,
              HasSubstr("DiscoverySettings::peers: 'a b'"));
}

}  // namespace
}  // namespace sft::core
