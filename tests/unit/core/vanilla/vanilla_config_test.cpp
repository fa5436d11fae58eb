// The participant for unmodified nodes has the configuration that a ROS 2 node would have in the same
// environment.
#include "core/vanilla/vanilla_config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "core/discovery/cyclone_settings.h"

namespace sft::core {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Optional;

auto is(const char* value) { return Optional(std::string(value)); }

CycloneSettings of_vanilla(const std::string& user, std::uint32_t domain = 0, const RosDiscovery& ros = {}) {
  return CycloneSettings::read(vanilla_config(domain, user, ros).value().text, domain).value();
}

TEST(VanillaConfig, IsThatOfTheUserWithTheInterfacesAndTheDomainOfTheUser) {
  const auto theirs = of_vanilla(
      "<General><Interfaces><NetworkInterface name=\"eth7\"/></><AllowMulticast>true</></>,"
      "<Discovery><ExternalDomainId>9</></>",
      3);
  EXPECT_THAT(theirs.values("General/Interfaces/NetworkInterface/@name"), ElementsAre("eth7"));
  EXPECT_THAT(theirs.value("General/AllowMulticast"), is("true"));
  EXPECT_THAT(theirs.value("Discovery/ExternalDomainId"), is("9"));
  EXPECT_THAT(of_vanilla("", 3).value("Discovery/ExternalDomainId"), is("3"));
}

TEST(VanillaConfig, MulticastsNoSamplesAndUsesNoRuntimeOfIceoryx) {
  EXPECT_THAT(of_vanilla("").value("General/AllowMulticast"), is("spdp"));
  EXPECT_THAT(of_vanilla("<SharedMemory><Enable>true</></>").value("SharedMemory/Enable"), is("false"));
}

TEST(VanillaConfig, AsksSoonForWhatIsThereUnlessTheUserSaysOtherwise) {
  EXPECT_THAT(of_vanilla("").value("Internal/PreEmptiveAckDelay"), is("3 ms"));
  EXPECT_THAT(of_vanilla("<Internal><PreEmptiveAckDelay>20 ms</></>").value("Internal/PreEmptiveAckDelay"),
              is("20 ms"));
}

TEST(VanillaConfig, LooksForNodesWhereRos2LooksUnlessTheUserSaysOtherwise) {
  const auto of_humble = of_vanilla("", 0, ros_discovery("1", nullptr, nullptr).value());
  EXPECT_THAT(of_humble.values("General/Interfaces/NetworkInterface/@address"), ElementsAre("127.0.0.1"));
  const auto local = of_vanilla("", 0, ros_discovery("0", "LOCALHOST", "far").value());
  EXPECT_THAT(local.value("General/AllowMulticast"), is("false"));
  EXPECT_THAT(local.values("Discovery/Peers/Peer/@address"), ElementsAre("localhost", "far"));
  EXPECT_THAT(local.value("Discovery/ParticipantIndex"), is("none"));
  const auto subnet = of_vanilla("", 0, ros_discovery("", "SUBNET", "10.0.0.7;;far").value());
  EXPECT_THAT(subnet.value("General/AllowMulticast"), is("spdp"));
  EXPECT_THAT(subnet.values("Discovery/Peers/Peer/@address"), ElementsAre("10.0.0.7", "far"));
  const RosDiscovery asks{.peers = {"far"}};
  EXPECT_THAT(
      of_vanilla("<Discovery><ParticipantIndex>auto</></>", 0, asks).value("Discovery/ParticipantIndex"),
      is("auto"));
  EXPECT_THAT(of_vanilla("", 0, ros_discovery(nullptr, "SYSTEM_DEFAULT", "far").value())
                  .values("Discovery/Peers/Peer/@address"),
              testing::IsEmpty());
}

TEST(VanillaConfig, ARangeThatRos2DoesNotHaveIsAnError) {
  EXPECT_TRUE(ros_discovery(nullptr, "OFF", nullptr).value().is_off);
  EXPECT_THAT(ros_discovery(nullptr, "WORLD", nullptr).error().message, HasSubstr("SUBNET"));
}

TEST(VanillaConfig, SaysThatTheUserWantsSecurity) {
  EXPECT_FALSE(vanilla_config(0, "").value().is_secured);
  for (const std::string group : {"Security", "DDSSecurity"}) {
    const std::string text = "<" + group + "><Authentication><Library path=\"a\"/></></>";
    EXPECT_TRUE(vanilla_config(0, text).value().is_secured);
  }
}

}  // namespace
}  // namespace sft::core
