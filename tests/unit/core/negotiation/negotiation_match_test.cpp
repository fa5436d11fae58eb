// Tests which pairs of a writer and a reader match, by which paths, and what is reported about pairs that do
// not match.
#include <gtest/gtest.h>

#include "sft/detail/type_description.h"
#include "sft/detail/type_shape.h"
#include "tests/unit/core/negotiation/negotiation_fixture.h"

namespace sft::core {
namespace {

using namespace detail;

using sensor_msgs::msg::PointCloud2;
using namespace std::chrono_literals;

/// Another definition of PointCloud2, with a height of 64 bits.
struct Taller {
  std::vector<Member> members{TypeTable<PointCloud2>::members.begin(), TypeTable<PointCloud2>::members.end()};
  StructType type = (members[1].kind = Kind::uint64, StructType("sensor_msgs::msg::PointCloud2", members));
};

TEST_F(NegotiationTest, AWriterThatMayNotWriteSharedMemoryServesItsHostByUdpAndSaysWhy) {
  negotiation.self_changed(
      {.host = token(1), .network = here, .memory_state = "iceoryx", .may_write_memory = false});
  our_writer();
  our_reader();
  negotiation.endpoint_seen(endpoint(Role::reader, 7, here, 1));
  EXPECT_FALSE(negotiation.serving(100).memory_port);
  EXPECT_EQ(negotiation.serving(100).readers.at(0).reason, "this user may only read shared memory");
  EXPECT_FALSE(negotiation.local(100)->host.known()) << "others would wait for it there";
  EXPECT_TRUE(negotiation.local(200)->host.known());
}

TEST_F(NegotiationTest, AReaderInAContainerIsServedInMemoryIfItSharesThatOrIsToldWhatIsMissing) {
  our_writer();
  const auto reason = [&](std::uint8_t host) {
    negotiation.endpoint_seen(endpoint(Role::reader, 7, beside, host));
    return negotiation.serving(100).readers.at(0).reason;
  };
  EXPECT_EQ(reason(1), "same host, shared memory is being attached");
  EXPECT_EQ(reason(2), "another host or container: it has a /dev/shm of its own");
  at_host({});
  EXPECT_EQ(reason(1), "no shared memory: off");
}

TEST_F(NegotiationTest, AReaderOnThisHostWithoutSharedMemorySaysWhyItHasNone) {
  our_writer();
  Endpoint reader = endpoint(Role::reader, 7, beside);
  reader.host = {};
  const auto reason = [&](const std::string& failure) {
    reader.memory_failure = failure;
    negotiation.endpoint_seen(reader);
    return negotiation.serving(100).readers.at(0).reason;
  };
  EXPECT_EQ(reason(""), "the other side has no shared memory yet");
  EXPECT_EQ(reason("/dev/shm is too small"), "the other side has no shared memory: /dev/shm is too small");
}

TEST_F(NegotiationTest, AReaderThatRulesUdpOutIsNotServedBeforeItIsAttached) {
  our_writer();
  Endpoint reader = endpoint(Role::reader, 7, here, 1);
  reader.may_use_network = false;
  negotiation.endpoint_seen(reader);
  const Serving serving = negotiation.serving(100);
  EXPECT_TRUE(serving.network.empty());
  EXPECT_TRUE(serving.memory_port);
  EXPECT_FALSE(serving.readers[0].served);
}

TEST_F(NegotiationTest, AnotherDefinitionOfTheTypeNeverMatchesAndSaysSo) {
  our_writer();
  Endpoint reader = endpoint(Role::reader, 7);
  reader.type_hash ^= 1;
  negotiation.endpoint_seen(reader);
  const Serving serving = negotiation.serving(100);
  EXPECT_TRUE(serving.network.empty());
  EXPECT_EQ(serving.readers.at(0).reason, "two different definitions of type sensor_msgs::msg::PointCloud2");
  ASSERT_NE(serving.readers.at(0).mismatch, nullptr);
  EXPECT_EQ(serving.readers.at(0).mismatch->there, "") << "it did not describe its own";
}

TEST_F(NegotiationTest, BothSidesAreToldTheFirstDifferenceBetweenTwoDefinitionsAndBothInFull) {
  const Taller other;
  our_writer();
  our_reader();
  Endpoint reader = endpoint(Role::reader, 7);
  Endpoint writer = endpoint(Role::writer, 8);
  for (Endpoint* e : {&reader, &writer}) {
    e->type_hash = structure_hash(other.type);
    e->type_description = detail::describe(other.type);
    negotiation.endpoint_seen(*e);
  }
  const Serving serving = negotiation.serving(100);
  const PublisherStatus::Reader& status = serving.readers.at(0);
  EXPECT_EQ(
      status.reason,
      "two different definitions of type sensor_msgs::msg::PointCloud2: height: uint32 here, uint64 there");
  ASSERT_NE(status.mismatch, nullptr);
  EXPECT_EQ(status.mismatch->difference, "height: uint32 here, uint64 there");
  EXPECT_EQ(status.mismatch->here, format_shape(type.type()));
  EXPECT_EQ(status.mismatch->there, format_shape(other.type));
  EXPECT_EQ(negotiation.serving(100), serving) << "nothing is new the second time";

  const std::vector<Hearing> hearing = negotiation.hearing(200);
  const SubscriberStatus::Writer& heard = hearing.at(0).status;
  EXPECT_EQ(heard.id, 8U);
  EXPECT_EQ(heard.reason, status.reason);
  EXPECT_NE(heard.mismatch, nullptr);
  EXPECT_EQ(hearing.at(1).status.mismatch, nullptr);
}

TEST_F(NegotiationTest, AnIncompatiblePairNeverMatchesAndBothSidesSayWhy) {
  our_writer();
  Endpoint reader = endpoint(Role::reader, 7);
  reader.qos.reliability = reliable;
  negotiation.endpoint_seen(reader);
  const Serving serving = negotiation.serving(100);
  EXPECT_TRUE(serving.network.empty());
  EXPECT_FALSE(serving.memory_port);
  EXPECT_FALSE(serving.readers.at(0).served);
  EXPECT_EQ(serving.readers.at(0).incompatible_policy, QosPolicy::reliability);

  Endpoint demanding = endpoint(Role::reader, 200);
  demanding.qos.deadline = 5ms;
  negotiation.local_added(demanding, type);
  Endpoint writer = endpoint(Role::writer, 8);
  writer.qos.deadline = 10ms;
  negotiation.endpoint_seen(writer);
  ASSERT_EQ(negotiation.hearing(200).size(), 2U);
  for (const Hearing& hearing : negotiation.hearing(200)) {
    EXPECT_FALSE(hearing.memory || hearing.network || hearing.status.matched);
    EXPECT_EQ(hearing.status.incompatible_policy, QosPolicy::deadline);
    EXPECT_NE(hearing.status.reason.find("is offered, 5 ms is requested"), std::string::npos);
  }
}

TEST_F(NegotiationTest, APairOfOneHostThatMayShareMemoryHasNoPathYetAndAnyOtherNeverHas) {
  our_writer();
  Endpoint reader = endpoint(Role::reader, 7, here, 1);
  reader.host = {};
  reader.may_use_network = false;
  const auto seen = [&] {
    negotiation.endpoint_seen(reader);
    return negotiation.serving(100).readers.at(0);
  };
  EXPECT_TRUE(seen().no_path);
  EXPECT_TRUE(seen().no_path_yet);
  reader.may_use_memory = false;
  reader.may_use_network = true;
  reader.addresses.clear();
  EXPECT_TRUE(seen().no_path);
  EXPECT_FALSE(seen().no_path_yet) << "they contradict each other";
  reader.may_use_memory = true;
  reader.network = elsewhere;
  EXPECT_TRUE(seen().no_path);
  EXPECT_FALSE(seen().no_path_yet) << "another host";
}

TEST_F(NegotiationTest, EndpointsOfOtherTopicsAreNobodysBusiness) {
  our_writer();
  Endpoint reader = endpoint(Role::reader, 7);
  reader.topic = "other";
  negotiation.endpoint_seen(reader);
  EXPECT_TRUE(negotiation.serving(100).readers.empty());
}

TEST_F(NegotiationTest, AReaderHearsWritersOfItsTopicByTheWaysBothAllow) {
  our_reader();
  negotiation.endpoint_seen(endpoint(Role::writer, 7, here, 1));
  Endpoint remote = endpoint(Role::writer, 8);
  remote.may_use_memory = false;
  negotiation.endpoint_seen(remote);
  const auto hearing = negotiation.hearing(200);
  ASSERT_EQ(hearing.size(), 2U);
  EXPECT_TRUE(hearing[0].memory && hearing[0].network);
  EXPECT_TRUE(!hearing[1].memory && hearing[1].network);
  EXPECT_EQ(hearing[1].status.reason, "the publisher or its node rules shared memory out");
}

TEST_F(NegotiationTest, WriterAndReaderOfOneNodeMatchLikeAnyOthers) {
  our_writer();
  our_reader();
  EXPECT_EQ(negotiation.serving(100).network.size(), 1U);
  EXPECT_TRUE(negotiation.serving(100).memory_port);
  negotiation.connection_changed(200, 100, true, true);
  EXPECT_EQ(negotiation.serving(100).memory.size(), 1U);
}

}  // namespace
}  // namespace sft::core
