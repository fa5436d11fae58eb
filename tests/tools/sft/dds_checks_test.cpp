// The checks report exactly those settings and nodes that prevent communication between DDS nodes and SFT.
#include "tools/sft/dds_checks.h"

#include <gmock/gmock.h>

namespace sft::tool {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// Returns the texts of the warnings, with what to do.
std::vector<std::string> warnings(const DdsEnvironment& environment, const DomainSnapshot& domain = {}) {
  std::vector<std::string> texts;
  for (const Finding& finding : check_dds(environment, domain))
    if (finding.health != Health::ok) texts.push_back(finding.text + ". " + finding.to_do);
  return texts;
}

TEST(DdsChecks, FindNothingInAnEnvironmentWithoutSuchSettings) {
  EXPECT_THAT(warnings({}), IsEmpty());
  EXPECT_THAT(warnings({.transports = "UDPv4", .security = "false", .middleware = "rmw_cyclonedds_cpp"}),
              IsEmpty());
  EXPECT_THAT(warnings({.middleware = "rmw_fastrtps_dynamic_cpp",
                        .range = "SUBNET",
                        .cyclone_config = "<Discovery><LeaseDuration>1 s</></>"}),
              IsEmpty());
}

TEST(DdsChecks, NameEachSettingWithItsValueAndWhatToSet) {
  EXPECT_THAT(warnings({.discovery_server = "10.0.0.1:11811"}),
              ElementsAre(AllOf(HasSubstr("ROS_DISCOVERY_SERVER is '10.0.0.1:11811'"), HasSubstr("Unset"))));
  for (const char* transports : {"SHM", "TCPv4", "LARGE_DATA"}) {
    EXPECT_THAT(warnings({.transports = transports}),
                ElementsAre(AllOf(HasSubstr(transports), HasSubstr("Set it to DEFAULT"))));
  }
  EXPECT_THAT(warnings({.security = "true"}), ElementsAre(HasSubstr("secured enclave")));
  EXPECT_THAT(warnings({.middleware = "rmw_zenoh_cpp"}),
              ElementsAre(AllOf(HasSubstr("'rmw_zenoh_cpp'"), HasSubstr("rmw_cyclonedds_cpp"))));
  EXPECT_THAT(warnings({.range = "OFF"}), ElementsAre(HasSubstr("SUBNET")));
  EXPECT_THAT(warnings({.cyclone_config = "<Discovery><Tag>mine</Tag></Discovery>"}),
              ElementsAre(HasSubstr("tag")));
  EXPECT_EQ(warnings({.discovery_server = "a", .transports = "SHM", .security = "true"}).size(), 3U);
}

TEST(DdsChecks, NameNodesThatHaveAnnouncedNothing) {
  DomainSnapshot domain;
  domain.dds_nodes = {{.name = "DDS 01", .host = "robot", .process = "talker (7)", .endpoints = 1}};
  EXPECT_TRUE(all_dds_nodes_have_answered(domain));
  EXPECT_THAT(warnings({}, domain), IsEmpty());
  domain.dds_nodes.push_back({.name = "DDS 02", .host = "robot", .process = "listener (8)"});
  domain.dds_nodes.push_back({.name = "DDS 03"});
  EXPECT_FALSE(all_dds_nodes_have_answered(domain));
  EXPECT_THAT(warnings({}, domain), ElementsAre(HasSubstr("DDS 02, listener (8) on robot, is heard"),
                                                HasSubstr("DDS 03 is heard")));
}

}  // namespace
}  // namespace sft::tool
