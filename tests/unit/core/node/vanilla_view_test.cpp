// A snapshot of the domain has the unmodified endpoints of DDS. For each pair with such an endpoint, it
// says whether the pair matches, and why or why not.
#include "core/node/vanilla_view.h"

#include <gmock/gmock.h>

#include <sensor_msgs/msg/PointCloud2.hpp>
#include <std_msgs/msg/Header.hpp>

#include "core/control/described_type.h"
#include "core/vanilla/type_hash.h"
#include "sft/detail/type_shape.h"

namespace sft::core {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

constexpr const char* cloud_type = "sensor_msgs::msg::dds_::PointCloud2_";

class VanillaViewTest : public testing::Test {
 protected:
  static VanillaEndpoints::OfTopic of(EndpointId id, const std::string& topic = "rt/points") {
    return {topic, {.id = id, .guid = "01", .participant = "DDS 01", .type_name = cloud_type}};
  }
  static DomainSnapshot::Endpoint endpoint(EndpointId id) {
    const auto& type = detail::TypeTable<sensor_msgs::msg::PointCloud2>::type;
    DomainSnapshot::Endpoint e;
    e.id = id;
    e.node = "camera";
    e.topic = "points";
    e.type_name = type.name;
    Endpoint announced;
    announced.type_name = type.name;
    announced.type_hash = detail::structure_hash(type);
    announced.type_description = announced_description(type).value();
    e.type = described_type(announced).value();
    return e;
  }
  DomainSnapshot snapshot() const {
    DomainSnapshot domain;
    domain.publishers = {endpoint(1)};
    domain.subscribers = {endpoint(2)};
    add_vanilla(domain, view, accounts);
    return domain;
  }
  DomainSnapshot::Pair pair() const { return snapshot().pairs.at(0); }
  static std::string our_hash() {
    return core::ros_type_hash(detail::TypeTable<sensor_msgs::msg::PointCloud2>::type).value();
  }

  VanillaView view;
  PairAccounts accounts;
};

TEST_F(VanillaViewTest, EndpointsHaveTheNamesOfSftAndComeInOrder) {
  view.writers = {of(10), of(11, "rt/arm/imu")};
  view.readers = {of(12, "rt/zone")};
  const DomainSnapshot domain = snapshot();
  ASSERT_EQ(domain.publishers.size(), 3U);
  EXPECT_EQ(domain.publishers[0].topic, "arm/imu");
  EXPECT_EQ(domain.publishers[1].id, 10U) << "its node is called DDS 01, and the other one camera";
  EXPECT_EQ(domain.publishers[1].type_name, "sensor_msgs::msg::PointCloud2");
  EXPECT_EQ(domain.publishers[1].dds->type_name, cloud_type);
  EXPECT_EQ(domain.publishers[1].qos.history_depth, 0U) << "unknown";
  EXPECT_FALSE(domain.publishers[2].dds);
  EXPECT_EQ(domain.subscribers.at(1).fields, "*");
}

TEST_F(VanillaViewTest, TopicsThatAreNotThoseOfRosAreLeftOutAndCountForTheirNodeNevertheless) {
  view.writers = {of(10, "Square"), of(11, "ros_discovery_info")};
  view.participants = {{"DDS 01", "robot", "talker (7)"}, {"DDS 02"}};
  const DomainSnapshot domain = snapshot();
  EXPECT_EQ(domain.publishers.size(), 1U);
  ASSERT_EQ(domain.dds_nodes.size(), 2U);
  EXPECT_EQ(domain.dds_nodes[0].endpoints, 2U);
  EXPECT_EQ(domain.dds_nodes[0].process, "talker (7)");
  EXPECT_EQ(domain.dds_nodes[1].endpoints, 0U);
}

TEST_F(VanillaViewTest, NamesThatNoNodeOfSftCouldHaveAreNotShown) {
  view.writers = {of(10, "rt/a\nb"), of(11, "rt/\xff")};
  view.readers = {of(12)};
  view.readers[0].endpoint.type_name = "Type\x1b[31m";
  view.participants = {{"DDS 01", "robot\n", "talker\x1b (7)"}};
  const DomainSnapshot domain = snapshot();
  EXPECT_EQ(domain.publishers.size() + domain.subscribers.size(), 2U);
  EXPECT_EQ(domain.dds_nodes.at(0).host + domain.dds_nodes.at(0).process, "");
}

TEST_F(VanillaViewTest, APairIsConnectedOnceTheNodeOfSftHasADdsEndpoint) {
  view.readers = {of(10)};
  EXPECT_TRUE(pair().matched && pair().dds_subscriber);
  EXPECT_FALSE(pair().connected);
  EXPECT_THAT(pair().reason, HasSubstr("has no DDS writer"));
  view.of_sft = {1};
  EXPECT_TRUE(pair().connected);
  EXPECT_EQ(pair().transport, TransportKind::dds);
  view = {.writers = {of(10)}};
  EXPECT_TRUE(pair().matched && pair().dds_publisher);
  EXPECT_THAT(pair().reason, HasSubstr("has no DDS reader"));
  view.of_sft = {2};
  EXPECT_TRUE(pair().connected);
  EXPECT_THAT(pair().reason, HasSubstr("conditions and rates are applied at the subscriber"));
}

TEST_F(VanillaViewTest, TwoEndpointsOfDdsAreNoPair) {
  view.writers = {of(10, "rt/zone")};
  view.readers = {of(11, "rt/zone")};
  EXPECT_THAT(snapshot().pairs, IsEmpty());
}

TEST_F(VanillaViewTest, WhatDoesNotMatchSaysWhy) {
  view.writers = {of(10)};
  view.writers[0].endpoint.type_name = "other";
  EXPECT_FALSE(pair().matched);
  EXPECT_TRUE(pair().incompatible_type);
  EXPECT_THAT(pair().reason, HasSubstr("'other'"));
  view = {.readers = {of(10)}};
  view.readers[0].endpoint.qos.durability = Durability::transient_local;
  EXPECT_FALSE(pair().matched);
  EXPECT_EQ(pair().incompatible_policy, QosPolicy::durability);
}

TEST_F(VanillaViewTest, DefinitionsAreComparedByTheHashesOfRos) {
  view.writers = {of(10)};
  EXPECT_THAT(pair().reason, HasSubstr("unverified"));
  view.writers[0].endpoint.type_hash = our_hash();
  EXPECT_TRUE(pair().matched);
  EXPECT_THAT(pair().reason, Not(HasSubstr("unverified")));
  view.writers[0].endpoint.type_hash = "RIHS01_0";
  EXPECT_FALSE(pair().matched);
  EXPECT_THAT(pair().reason, AllOf(HasSubstr("RIHS01_0"), HasSubstr(our_hash())));
  view = {.readers = {of(10)}, .of_sft = {1}};
  view.readers[0].endpoint.type_hash = "RIHS01_0";
  EXPECT_TRUE(pair().connected) << "DDS compares names only";
  EXPECT_THAT(pair().reason, AllOf(HasSubstr("RIHS01_0"), HasSubstr(our_hash()), HasSubstr("misreads")));
}

TEST_F(VanillaViewTest, APublisherThatSomeReaderDoesNotAnswerSaysSo) {
  view = {.readers = {of(10)}, .of_sft = {1}};
  EXPECT_THAT(pair().reason, Not(HasSubstr("acknowledge")));
  view.unanswered = {1};
  EXPECT_TRUE(pair().connected);
  EXPECT_THAT(pair().reason, HasSubstr("does not acknowledge what the publisher sends"));
}

TEST_F(VanillaViewTest, TheCountsOfTheSubscribersNodeAreThoseOfThePair) {
  view.writers = {of(10)};
  accounts[{10, 2}].subscriber = DomainSnapshot::Received{.received = 3, .lost = 1};
  EXPECT_EQ(pair().account.subscriber->received, 3U);
}

}  // namespace
}  // namespace sft::core
