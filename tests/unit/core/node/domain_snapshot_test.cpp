// The snapshot contains all endpoints of a domain, including pairs that belong to other nodes only.
#include "core/node/domain_snapshot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nav_msgs/msg/Odometry.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>

#include "core/control/described_type.h"
#include "sft/detail/type_shape.h"
#include "sft/type_support.h"

namespace sft::core {
namespace {

using namespace detail;

using nav_msgs::msg::Odometry;
using sensor_msgs::msg::PointCloud2;
using ::testing::HasSubstr;

constexpr NodeId our_node = 7;
constexpr std::uint64_t this_machine = std::uint64_t{1} << 32 | 1;
constexpr std::uint64_t another_machine = std::uint64_t{2} << 32 | 1;

class DomainSnapshotTest : public ::testing::Test {
 protected:
  static Endpoint endpoint(Role role, EndpointId id, const StructType& type = TypeTable<PointCloud2>::type) {
    Endpoint e;
    e.role = role;
    e.id = id;
    e.node_id = 100 + id;
    e.node = role == Role::writer ? "lidar" : "monitor";
    e.topic = "points";
    e.type_name = type.name;
    e.type_hash = structure_hash(type);
    e.type_description = announced_description(type).value();
    e.host.bytes[0] = 1;
    e.network = this_machine;
    e.may_use_memory = e.may_use_network = true;
    e.addresses = {{loopback_ipv4, 4000}};
    e.request.mask_words = FieldMask(PointCloud2::Field::width | PointCloud2::Field::height).to_words();
    e.request.sequence = 3;
    return e;
  }
  DomainSnapshot snapshot() const {
    return domain_snapshot({{.endpoint = writer}, {.endpoint = reader}}, {}, our_node, this_machine);
  }
  DomainSnapshot::Pair pair() const { return snapshot().pairs.at(0); }

  Endpoint writer = endpoint(Role::writer, 1);
  Endpoint reader = endpoint(Role::reader, 2);
};

TEST_F(DomainSnapshotTest, APairThatSharesMemoryIsConnectedOnceTheReaderSaysSo) {
  EXPECT_TRUE(pair().matched);
  EXPECT_FALSE(pair().connected);
  reader.request.attached = {writer.id};
  EXPECT_TRUE(pair().connected);
  EXPECT_EQ(pair().transport, TransportKind::shm);
  EXPECT_EQ(pair().reason, "same host");
}

TEST_F(DomainSnapshotTest, APairOnTwoOtherHostsGoesByUdpAsBothOfThemSee) {
  writer.network = another_machine;
  reader.network = std::uint64_t{3} << 32;
  reader.host.bytes[0] = 2;
  reader.request.listening = {writer.id};
  EXPECT_TRUE(pair().connected);
  EXPECT_EQ(pair().transport, TransportKind::udp);
  EXPECT_EQ(pair().reason, "another host");
  EXPECT_FALSE(snapshot().publishers.at(0).same_machine);
}

TEST_F(DomainSnapshotTest, APairOnOneHostWithoutSharedMemoryHasTheReasonOfItsNode) {
  writer.host = {};
  writer.memory_failure = "no rights";
  EXPECT_EQ(pair().reason, "no shared memory: the publisher's node: no rights");
  writer.host = reader.host;
  reader.host = {};
  reader.memory_failure = "/dev/shm is too small";
  EXPECT_EQ(pair().reason, "the other side has no shared memory: /dev/shm is too small");
}

TEST_F(DomainSnapshotTest, PoliciesAndTypesThatDoNotFitAreNamed) {
  reader.qos.reliability = Reliability::reliable;
  EXPECT_FALSE(pair().matched);
  EXPECT_EQ(pair().incompatible_policy, QosPolicy::reliability);
  EXPECT_EQ(
      pair().reason,
      "incompatible QoS: reliability best_effort is offered, reliable is requested: open the publisher with "
      ".reliability = reliable, or the subscriber with .reliability = best_effort");
  reader = endpoint(Role::reader, 2, TypeTable<Odometry>::type);
  EXPECT_TRUE(pair().incompatible_type);
  EXPECT_THAT(pair().reason, HasSubstr("nav_msgs::msg::Odometry is subscribed to"));
}

TEST_F(DomainSnapshotTest, TwoDefinitionsOfATypeAreCompared) {
  std::vector<Member> members(TypeTable<PointCloud2>::members.begin(), TypeTable<PointCloud2>::members.end());
  members[1].kind = Kind::uint64;
  reader = endpoint(Role::reader, 2, StructType(TypeTable<PointCloud2>::type.name, members));
  ASSERT_NE(pair().mismatch, nullptr);
  EXPECT_EQ(pair().mismatch->difference, "height: uint32 here, uint64 there");
  writer.type_description.clear();
  EXPECT_EQ(pair().mismatch, nullptr);
  EXPECT_THAT(pair().reason, HasSubstr("two different definitions"));
}

TEST_F(DomainSnapshotTest, APairWithoutACommonWayIsToldWhy) {
  writer.may_use_network = false;
  reader.may_use_memory = false;
  EXPECT_TRUE(pair().no_path);
  EXPECT_EQ(pair().reason, "UDP is ruled out, and the subscriber or its node rules shared memory out");
}

TEST_F(DomainSnapshotTest, FieldsRatesAndProgressAreTold) {
  reader.request.min_period_us = 50'000;
  const DomainSnapshot domain =
      domain_snapshot({{.endpoint = reader}, {.endpoint = writer, .progress = Progress{writer.id, 12, 345}}},
                      {}, reader.node_id, this_machine);
  const DomainSnapshot::Endpoint& subscriber = domain.subscribers.at(0);
  EXPECT_EQ(subscriber.fields, "height, width");
  EXPECT_EQ(subscriber.max_rate_hz, 20);
  EXPECT_EQ(subscriber.requests, 3U);
  EXPECT_TRUE(subscriber.is_own);
  EXPECT_THAT(subscriber.addresses, ::testing::ElementsAre("127.0.0.1:4000"));
  const DomainSnapshot::Endpoint& publisher = domain.publishers.at(0);
  EXPECT_FALSE(publisher.is_own);
  EXPECT_EQ(publisher.type->name(), "sensor_msgs::msg::PointCloud2");
  EXPECT_EQ(publisher.progress->samples, 12U);
  EXPECT_EQ(publisher.progress->bytes, 345U);
}

TEST_F(DomainSnapshotTest, APairHasTheAccountsThatItsNodesHaveTold) {
  PairAccounts accounts;
  accounts[{writer.id, reader.id}].subscriber = DomainSnapshot::Received{.age = {}, .received = 5, .lost = 1};
  accounts[{reader.id, writer.id}].publisher = DomainSnapshot::Sent{};  // an account of another pair, with
                                                                        // swapped ids
  const DomainSnapshot::Pair reported =
      domain_snapshot({{.endpoint = writer}, {.endpoint = reader}}, accounts, our_node, this_machine)
          .pairs.at(0);
  EXPECT_FALSE(reported.account.publisher);
  ASSERT_TRUE(reported.account.subscriber);
  EXPECT_EQ(reported.account.subscriber->received, 5U);
  EXPECT_EQ(reported.account.subscriber->lost, 1U);
}

TEST_F(DomainSnapshotTest, EndpointsOfDifferentTopicsAreNoPair) {
  reader.topic = "clouds";
  EXPECT_TRUE(snapshot().pairs.empty());
}

}  // namespace
}  // namespace sft::core
