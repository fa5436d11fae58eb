// The negotiation as pure functions of events: what each of our writers serves and each of our readers hears.
#include "core/negotiation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <sensor_msgs/msg/PointCloud2.hpp>

#include "sft/typesupport/type_description.h"
#include "sft/typesupport/type_shape.h"

namespace sft::core {
namespace {

using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;
using namespace std::chrono_literals;

constexpr std::uint64_t here = 1;
constexpr std::uint64_t elsewhere = 2;

HostToken token(std::uint8_t n) {
  HostToken t;
  t.bytes.fill(n);
  return t;
}

std::vector<std::uint64_t> words(const Mask<PointCloud2>& mask) {
  return {mask.words.begin(), mask.words.end()};
}

/// Another definition of PointCloud2, with a wider height.
struct Taller {
  std::vector<Member> members{TypeTable<PointCloud2>::members.begin(), TypeTable<PointCloud2>::members.end()};
  StructType type = (members[1].kind = Kind::uint64, StructType("sensor_msgs::msg::PointCloud2", members));
};

class NegotiationTest : public ::testing::Test {
 protected:
  NegotiationTest() { at_host(token(1)); }

  void at_host(const HostToken& host) {
    negotiation.self_changed({.host = host, .network = here, .shm_state = "off"});
  }

  Endpoint endpoint(Role role, EndpointId id, std::uint64_t network = elsewhere, std::uint8_t host = 2) {
    Endpoint e;
    e.id = id;
    e.role = role;
    e.topic = "points";
    e.type_name = type.name();
    e.type_hash = type.hash();
    e.host = token(host);
    e.network = network;
    e.may_use_shm = e.may_use_udp = true;
    e.addresses = {{0x0a000001, 7000, 1 << 20}};
    e.doorbell = {id, 1};
    e.max_sample_bytes = 1 << 20;
    e.request = {.reader = id,
                 .sequence = 1,
                 .mask_words = words(F::height | F::width),
                 .listening = {100},
                 .attached = {},
                 .begun = {}};
    return e;
  }

  Request request(EndpointId reader, std::uint64_t sequence, const Mask<PointCloud2>& mask,
                  std::vector<EndpointId> attached = {}) {
    return {.reader = reader,
            .sequence = sequence,
            .mask_words = words(mask),
            .listening = {100},
            .attached = std::move(attached),
            .begun = {}};
  }

  void our_writer() { negotiation.local_added(endpoint(Role::writer, 100), type); }
  void our_reader() { negotiation.local_added(endpoint(Role::reader, 200), type); }

  const TypeSupport type{TypeTable<PointCloud2>::type};
  Negotiation negotiation;
};

TEST_F(NegotiationTest, AWriterWithoutReadersServesNobody) {
  our_writer();
  const Serving serving = negotiation.serving(100);
  EXPECT_TRUE(serving.udp.empty());
  EXPECT_TRUE(serving.shm.empty());
  EXPECT_FALSE(serving.shm_port);
}

TEST_F(NegotiationTest, AReaderOnAnotherHostIsServedByUdpWithTheMaskOfItsFirstRequest) {
  our_writer();
  negotiation.endpoint_seen(endpoint(Role::reader, 7));
  const Serving serving = negotiation.serving(100);
  ASSERT_EQ(serving.udp.size(), 1U);
  EXPECT_EQ(serving.udp[0].mask, FieldMask(F::height | F::width));
  EXPECT_EQ(std::get<UdpAddress>(serving.udp[0].destination).ipv4, 0x0a000001U);
  EXPECT_EQ(serving.readers[0].reason, "another host");
  EXPECT_FALSE(serving.shm_port);
}

TEST_F(NegotiationTest, NothingIsSentToAReaderBeforeItSaysThatItListens) {
  our_writer();
  Endpoint reader = endpoint(Role::reader, 7);
  reader.request.listening.clear();
  negotiation.endpoint_seen(reader);
  EXPECT_TRUE(negotiation.serving(100).udp.empty());
  EXPECT_EQ(negotiation.serving(100).readers.at(0).reason, "the subscriber is not listening yet");
  negotiation.request_received(request(7, 2, F::data));
  EXPECT_EQ(negotiation.serving(100).udp.at(0).mask, FieldMask(F::data));
}

TEST_F(NegotiationTest, AWriterThatMayNotWriteSharedMemoryServesItsHostByUdpAndSaysWhy) {
  negotiation.self_changed(
      {.host = token(1), .network = here, .shm_state = "iceoryx", .may_write_shm = false});
  our_writer();
  our_reader();
  negotiation.endpoint_seen(endpoint(Role::reader, 7, here, 1));
  EXPECT_FALSE(negotiation.serving(100).shm_port);
  EXPECT_EQ(negotiation.serving(100).readers.at(0).reason, "this user may only read shared memory");
  EXPECT_FALSE(negotiation.local(100)->host.known()) << "others would wait for it there";
  EXPECT_TRUE(negotiation.local(200)->host.known());
}

TEST_F(NegotiationTest, AReaderIsReachedInANetworkThatWeAreInToo) {
  our_writer();
  Endpoint reader = endpoint(Role::reader, 7);
  reader.addresses.push_back({0x0b000001, 7000, 1 << 20});
  negotiation.endpoint_seen(reader);
  const auto destination = [&] {
    return std::get<UdpAddress>(negotiation.serving(100).udp.at(0).destination).ipv4;
  };
  EXPECT_EQ(destination(), 0x0a000001U);
  EXPECT_TRUE(negotiation.network_changed({}, {{0x0b000002, 0xffffff00}}));
  EXPECT_EQ(destination(), 0x0b000001U);
}

TEST_F(NegotiationTest, OurEndpointsAreAnnouncedWithTheAddressesOfNow) {
  our_reader();
  const std::vector<UdpAddress> before{{0x0a000001, 7000, 1 << 20}}, after{{0x0b000001, 7000, 1 << 20}};
  EXPECT_EQ(negotiation.local(200)->addresses, before);
  negotiation.network_changed(after, {});
  EXPECT_EQ(negotiation.local(200)->addresses, after);
  our_writer();  // made with those of before
  EXPECT_EQ(negotiation.local(100)->addresses, after);
}

TEST_F(NegotiationTest, ANodeThatIsSilentIsNotServedUntilItIsHeardOfAgainAndNotForgotten) {
  our_writer();
  Endpoint reader = endpoint(Role::reader, 7), other = endpoint(Role::reader, 8);
  reader.node_id = 70;
  other.node_id = 80;
  negotiation.endpoint_seen(reader);
  negotiation.endpoint_seen(other);
  EXPECT_FALSE(negotiation.misses_somebody());
  EXPECT_TRUE(negotiation.node_lost(70));
  EXPECT_TRUE(negotiation.misses_somebody());
  negotiation.tick(Now{} + 1h);
  ASSERT_EQ(negotiation.serving(100).udp.size(), 1U);
  EXPECT_EQ(negotiation.serving(100).udp[0].reader, 8U);
  EXPECT_EQ(negotiation.serving(100).readers.at(0).reason, "its node does not answer");
  EXPECT_TRUE(negotiation.node_returned(70));
  EXPECT_EQ(negotiation.serving(100).udp.size(), 2U);
  EXPECT_FALSE(negotiation.node_returned(70)) << "that is no news";
}

TEST_F(NegotiationTest, ANodeThatReturnsIsServedAsItAskedMeanwhile) {
  our_writer();
  Endpoint reader = endpoint(Role::reader, 7);
  reader.node_id = 70;
  negotiation.endpoint_seen(reader);
  negotiation.node_lost(70);
  negotiation.request_received(request(7, 2, F::data));
  negotiation.node_returned(70);
  EXPECT_EQ(negotiation.serving(100).udp.at(0).mask, FieldMask(F::data));
}

TEST_F(NegotiationTest, ANodeThatDiscoveryHasGivenUpReturnsOnlyByDiscovery) {
  our_writer();
  Endpoint reader = endpoint(Role::reader, 7);
  reader.node_id = 70;
  negotiation.endpoint_seen(reader);
  negotiation.node_lost(70);
  negotiation.endpoint_lost(7, Now{});
  negotiation.node_returned(70);
  EXPECT_TRUE(negotiation.serving(100).udp.empty());
  negotiation.endpoint_seen(reader);
  EXPECT_EQ(negotiation.serving(100).udp.size(), 1U);
}

TEST_F(NegotiationTest, AReaderInTheSameNetworkStackIsReachedThroughLoopback) {
  our_writer();
  negotiation.endpoint_seen(endpoint(Role::reader, 7, here, 3));
  EXPECT_EQ(std::get<UdpAddress>(negotiation.serving(100).udp.at(0).destination).ipv4, 0x7f000001U);
}

TEST_F(NegotiationTest, AReaderThatSharesMemoryIsServedByUdpUntilItIsAttachedAndThenByMemoryOnly) {
  our_writer();
  negotiation.endpoint_seen(endpoint(Role::reader, 7, here, 1));
  Serving serving = negotiation.serving(100);
  EXPECT_TRUE(serving.shm_port);
  EXPECT_EQ(serving.udp.size(), 1U);
  EXPECT_TRUE(serving.shm.empty());

  negotiation.request_received(request(7, 2, F::height | F::width, {100}));
  serving = negotiation.serving(100);
  EXPECT_TRUE(serving.udp.empty());
  ASSERT_EQ(serving.shm.size(), 1U);
  EXPECT_EQ(std::get<DoorbellAddress>(serving.shm[0].destination).page, 7U);
  EXPECT_EQ(serving.readers[0].reason, "same host");
}

TEST_F(NegotiationTest, WhenTheMemoryIsLostItsReadersAreServedByUdpAgain) {
  our_writer();
  negotiation.endpoint_seen(endpoint(Role::reader, 7, here, 1));
  negotiation.request_received(request(7, 2, F::height, {100}));
  at_host({});
  const Serving serving = negotiation.serving(100);
  EXPECT_TRUE(serving.shm.empty());
  EXPECT_EQ(serving.udp.size(), 1U);
  EXPECT_EQ(serving.readers[0].reason, "no shared memory: off");
}

TEST_F(NegotiationTest, AReaderThatRulesUdpOutIsNotServedBeforeItIsAttached) {
  our_writer();
  Endpoint reader = endpoint(Role::reader, 7, here, 1);
  reader.may_use_udp = false;
  negotiation.endpoint_seen(reader);
  const Serving serving = negotiation.serving(100);
  EXPECT_TRUE(serving.udp.empty());
  EXPECT_TRUE(serving.shm_port);
  EXPECT_FALSE(serving.readers[0].served);
}

TEST_F(NegotiationTest, ALaterRequestReplacesTheMaskAndAReorderedOrRepeatedOneDoesNot) {
  our_writer();
  negotiation.endpoint_seen(endpoint(Role::reader, 7));
  EXPECT_TRUE(negotiation.request_received(request(7, 5, F::data)));
  EXPECT_FALSE(negotiation.request_received(request(7, 5, F::height)));
  EXPECT_FALSE(negotiation.request_received(request(7, 4, F::height)));
  EXPECT_EQ(negotiation.serving(100).udp.at(0).mask, FieldMask(F::data));
}

TEST_F(NegotiationTest, ARequestThatComesBeforeItsReaderIsKeptForIt) {
  our_writer();
  negotiation.request_received(request(7, 3, F::data));
  negotiation.endpoint_seen(endpoint(Role::reader, 7));
  EXPECT_EQ(negotiation.serving(100).udp.at(0).mask, FieldMask(F::data));
}

TEST_F(NegotiationTest, ARepeatedAnnouncementDoesNotTakeALaterRequestBack) {
  our_writer();
  negotiation.endpoint_seen(endpoint(Role::reader, 7));
  negotiation.request_received(request(7, 3, F::data));
  negotiation.endpoint_seen(endpoint(Role::reader, 7));
  EXPECT_EQ(negotiation.serving(100).udp.at(0).mask, FieldMask(F::data));
}

TEST_F(NegotiationTest, ALostReaderIsNotServedButItsMaskIsKeptUntilItReturns) {
  our_writer();
  negotiation.endpoint_seen(endpoint(Role::reader, 7));
  negotiation.request_received(request(7, 3, F::data));
  negotiation.endpoint_lost(7, Now{});
  EXPECT_TRUE(negotiation.serving(100).udp.empty());
  EXPECT_EQ(negotiation.serving(100).readers.at(0).reason, "its node does not answer");

  negotiation.endpoint_seen(endpoint(Role::reader, 7));
  EXPECT_EQ(negotiation.serving(100).udp.at(0).mask, FieldMask(F::data));
}

// The two control topics come back one after the other, and each tells what it has only once.
TEST_F(NegotiationTest, ARequestThatComesBackBeforeItsLostReaderOutlivesThatThisIsForgottenMeanwhile) {
  our_writer();
  negotiation.endpoint_seen(endpoint(Role::reader, 7));
  negotiation.endpoint_lost(7, Now{});
  negotiation.request_received(request(7, 3, F::data));
  EXPECT_TRUE(negotiation.tick(Now{} + 60s));
  negotiation.endpoint_seen(endpoint(Role::reader, 7));
  EXPECT_EQ(negotiation.serving(100).udp.at(0).mask, FieldMask(F::data));
}

TEST_F(NegotiationTest, ALostReaderIsForgottenAfterAWhileAndADepartedOneAtOnce) {
  our_writer();
  negotiation.endpoint_seen(endpoint(Role::reader, 7));
  negotiation.endpoint_seen(endpoint(Role::reader, 8));
  negotiation.endpoint_departed(8);
  negotiation.endpoint_lost(7, Now{});
  EXPECT_FALSE(negotiation.tick(Now{} + 59s));
  EXPECT_EQ(negotiation.serving(100).readers.size(), 1U);
  EXPECT_TRUE(negotiation.tick(Now{} + 60s));
  EXPECT_TRUE(negotiation.serving(100).readers.empty());
}

TEST_F(NegotiationTest, AnotherDefinitionOfTheTypeNeverMatchesAndSaysSo) {
  our_writer();
  Endpoint reader = endpoint(Role::reader, 7);
  reader.type_hash ^= 1;
  negotiation.endpoint_seen(reader);
  const Serving serving = negotiation.serving(100);
  EXPECT_TRUE(serving.udp.empty());
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
    e->type_description = describe(other.type);
    negotiation.endpoint_seen(*e);
  }
  const Serving serving = negotiation.serving(100);
  const ReaderStatus& status = serving.readers.at(0);
  EXPECT_EQ(
      status.reason,
      "two different definitions of type sensor_msgs::msg::PointCloud2: height: uint32 here, uint64 there");
  ASSERT_NE(status.mismatch, nullptr);
  EXPECT_EQ(status.mismatch->difference, "height: uint32 here, uint64 there");
  EXPECT_EQ(status.mismatch->here, format_shape(type.type()));
  EXPECT_EQ(status.mismatch->there, format_shape(other.type));
  EXPECT_EQ(negotiation.serving(100), serving) << "nothing is new the second time";

  const std::vector<Hearing> hearing = negotiation.hearing(200);
  const WriterStatus& heard = hearing.at(0).status;
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
  EXPECT_TRUE(serving.udp.empty());
  EXPECT_FALSE(serving.shm_port);
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
    EXPECT_FALSE(hearing.shm || hearing.udp || hearing.status.matched);
    EXPECT_EQ(hearing.status.incompatible_policy, QosPolicy::deadline);
    EXPECT_NE(hearing.status.reason.find("is offered, 5 ms is requested"), std::string::npos);
  }
}

TEST_F(NegotiationTest, AWriterIsAssertedForReadersThatAskedForALease) {
  Endpoint writer = endpoint(Role::writer, 100);
  writer.qos.liveliness_lease = 1s;
  negotiation.local_added(writer, type);
  negotiation.endpoint_seen(endpoint(Role::reader, 7));
  EXPECT_FALSE(negotiation.serving(100).lease_requested);
  Endpoint reader = endpoint(Role::reader, 8);
  reader.qos.liveliness_lease = 2s;
  negotiation.endpoint_seen(reader);
  EXPECT_TRUE(negotiation.serving(100).lease_requested);
  EXPECT_TRUE(negotiation.serving(100).samples_tell);
  Request slower = request(8, 2, F::data);
  slower.min_period_us = 1;
  negotiation.request_received(slower);
  EXPECT_FALSE(negotiation.serving(100).samples_tell);
}

TEST_F(NegotiationTest, AWriterWhoseNodeDoesNotAnswerIsHeardOfAsNotAlive) {
  our_reader();
  negotiation.endpoint_seen(endpoint(Role::writer, 7));
  EXPECT_TRUE(negotiation.hearing(200).at(0).status.alive);
  negotiation.endpoint_lost(7, Now{});
  EXPECT_FALSE(negotiation.hearing(200).at(0).status.alive);
  EXPECT_EQ(negotiation.hearing(200).at(0).status.reason, "its node does not answer");
}

TEST_F(NegotiationTest, AWriterIsConnectedOnceOurReaderListensToItAndWhileItsNodeAnswers) {
  our_reader();
  negotiation.endpoint_seen(endpoint(Role::writer, 7));
  const auto heard = [&] { return negotiation.hearing(200).at(0).status; };
  EXPECT_TRUE(heard().matched);
  EXPECT_FALSE(heard().connected);
  negotiation.connection_changed(200, 7, TransportKind::udp, true);
  EXPECT_TRUE(heard().connected);
  negotiation.endpoint_lost(7, Now{});
  EXPECT_TRUE(heard().matched);
  EXPECT_FALSE(heard().connected);
}

TEST_F(NegotiationTest, APairOfOneHostThatMayShareMemoryHasNoPathYetAndAnyOtherNeverHas) {
  our_writer();
  Endpoint reader = endpoint(Role::reader, 7, here, 1);
  reader.host = {};
  reader.may_use_udp = false;
  const auto seen = [&] {
    negotiation.endpoint_seen(reader);
    return negotiation.serving(100).readers.at(0);
  };
  EXPECT_TRUE(seen().no_path);
  EXPECT_TRUE(seen().no_path_yet);
  reader.may_use_shm = false;
  reader.may_use_udp = true;
  reader.addresses.clear();
  EXPECT_TRUE(seen().no_path);
  EXPECT_FALSE(seen().no_path_yet) << "they contradict each other";
  reader.may_use_shm = true;
  reader.network = elsewhere;
  EXPECT_TRUE(seen().no_path);
  EXPECT_FALSE(seen().no_path_yet) << "another host";
}

class LateReaderTest : public NegotiationTest {
 protected:
  LateReaderTest() {
    Endpoint writer = endpoint(Role::writer, 100);
    writer.qos = {.durability = transient_local, .history_depth = 5};
    negotiation.local_added(writer, type);
  }
  /// On this host, and attached.
  Endpoint late_reader(EndpointId id = 7) {
    Endpoint reader = endpoint(Role::reader, id, here, 1);
    reader.qos = {.durability = transient_local, .history_depth = 3};
    reader.request.attached = {100};
    return reader;
  }
  /// It says that what is for it alone has begun to come.
  void begin(EndpointId reader, std::uint64_t sequence) {
    Request begun = request(reader, sequence, F::data, {100});
    begun.begun = {100};
    negotiation.request_received(begun);
  }
};

TEST_F(LateReaderTest, GetsByUdpWhatBothSidesKeepAndChangesOverToSharedMemoryThen) {
  negotiation.endpoint_seen(late_reader());
  Serving serving = negotiation.serving(100);
  EXPECT_TRUE(serving.shm.empty());
  ASSERT_EQ(serving.udp.size(), 1U);
  EXPECT_EQ(serving.udp[0].history, 3U);
  EXPECT_TRUE(serving.history_owed);
  EXPECT_FALSE(negotiation.history_given(100, 7)) << "nothing of it has come yet";
  begin(7, 2);
  EXPECT_TRUE(negotiation.serving(100).history_owed) << "not all of it has left yet";
  EXPECT_TRUE(negotiation.history_given(100, 7));
  EXPECT_FALSE(negotiation.history_given(100, 7));
  serving = negotiation.serving(100);
  EXPECT_TRUE(serving.udp.empty());
  EXPECT_EQ(serving.shm.size(), 1U);
  EXPECT_FALSE(serving.history_owed);
}

TEST_F(LateReaderTest, GetsNothingRetainedThroughSharedMemoryAloneAndIsTold) {
  Endpoint reader = late_reader();
  reader.may_use_udp = false;
  negotiation.endpoint_seen(reader);
  const Serving serving = negotiation.serving(100);
  EXPECT_EQ(serving.shm.size(), 1U);
  EXPECT_EQ(serving.readers.at(0).reason, "same host; without UDP nothing of what was published before");
}

TEST_F(LateReaderTest, ThatIsVolatileGetsNothing) {
  Endpoint reader = late_reader();
  reader.qos.durability = volatile_;
  negotiation.endpoint_seen(reader);
  EXPECT_EQ(negotiation.serving(100).shm.size(), 1U);
}

TEST_F(LateReaderTest, ThatWasLostAndReturnsIsNotGivenItAgainAndOneThatWentIs) {
  negotiation.endpoint_seen(late_reader());
  begin(7, 2);
  negotiation.history_given(100, 7);
  negotiation.endpoint_lost(7, Now{});
  negotiation.endpoint_seen(late_reader());
  EXPECT_EQ(negotiation.serving(100).shm.size(), 1U);
  negotiation.endpoint_departed(7);
  negotiation.endpoint_seen(late_reader());
  EXPECT_EQ(negotiation.serving(100).udp.size(), 1U);
}

TEST_F(LateReaderTest, ThatLostUsAndFoundUsAgainIsGivenItAgain) {
  negotiation.endpoint_seen(late_reader());
  begin(7, 2);
  negotiation.history_given(100, 7);
  negotiation.request_received(request(7, 3, F::data, {100}));
  EXPECT_TRUE(negotiation.serving(100).history_owed);
  begin(7, 4);
  EXPECT_TRUE(negotiation.serving(100).history_owed) << "it has begun, but not all of it has left yet";
}

TEST_F(NegotiationTest, OurReaderIsAttachedOnlyOnceTheHistoryHasCome) {
  Endpoint reader = endpoint(Role::reader, 200);
  reader.qos.durability = transient_local;
  negotiation.local_added(reader, type);
  Endpoint writer = endpoint(Role::writer, 7, here, 1);
  writer.qos.durability = transient_local;
  negotiation.endpoint_seen(writer);
  EXPECT_FALSE(negotiation.hearing(200).at(0).shm);
  EXPECT_EQ(negotiation.hearing(200).at(0).status.reason, "same host, what was published before comes first");
  negotiation.history_began(200, 7);
  EXPECT_FALSE(negotiation.hearing(200).at(0).shm);
  EXPECT_TRUE(negotiation.history_came(200, 7));
  EXPECT_FALSE(negotiation.history_came(200, 7));
  EXPECT_TRUE(negotiation.hearing(200).at(0).shm);
}

TEST_F(NegotiationTest, OurReaderTakesNothingOfADurableWriterBeforeWhatThatRetained) {
  Endpoint reader = endpoint(Role::reader, 200);
  reader.qos.durability = transient_local;
  negotiation.local_added(reader, type);
  Endpoint writer = endpoint(Role::writer, 7);
  negotiation.endpoint_seen(writer);
  EXPECT_FALSE(negotiation.hearing(200).at(0).source.history_first);
  writer.qos.durability = transient_local;
  negotiation.endpoint_seen(writer);
  EXPECT_TRUE(negotiation.hearing(200).at(0).source.history_first);
  EXPECT_TRUE(negotiation.history_began(200, 7));
  EXPECT_FALSE(negotiation.history_began(200, 7));
  EXPECT_EQ(negotiation.local(200)->request.begun, std::vector<EndpointId>{7});
  negotiation.connection_changed(200, 7, TransportKind::udp, true);
  negotiation.connection_changed(200, 7, TransportKind::udp, false);
  EXPECT_TRUE(negotiation.local(200)->request.begun.empty());
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
  remote.may_use_shm = false;
  negotiation.endpoint_seen(remote);
  const auto hearing = negotiation.hearing(200);
  ASSERT_EQ(hearing.size(), 2U);
  EXPECT_TRUE(hearing[0].shm && hearing[0].udp);
  EXPECT_TRUE(!hearing[1].shm && hearing[1].udp);
  EXPECT_EQ(hearing[1].status.reason, "the publisher or its node rules shared memory out");
}

TEST_F(NegotiationTest, EveryChangeOfARequirementOrAnAttachmentIsANewerRequest) {
  our_reader();
  const std::uint64_t first = negotiation.local(200)->request.sequence;
  EXPECT_TRUE(negotiation.requirement_changed(200, FieldMask(F::data | F::height)));
  EXPECT_FALSE(negotiation.requirement_changed(200, FieldMask(F::data | F::height)));
  EXPECT_TRUE(negotiation.connection_changed(200, 7, TransportKind::shm, true));
  EXPECT_FALSE(negotiation.connection_changed(200, 7, TransportKind::shm, true));
  EXPECT_EQ(negotiation.local(200)->request.sequence, first + 2);
  EXPECT_EQ(negotiation.local(200)->request.attached, std::vector<EndpointId>{7});
}

TEST_F(NegotiationTest, AReaderIsServedReliablyAndHearsSoIfItAsksForThat) {
  Endpoint writer = endpoint(Role::writer, 100);
  writer.qos.reliability = Reliability::reliable;
  negotiation.local_added(writer, type);
  for (const EndpointId id : {7U, 8U}) {
    Endpoint reader = endpoint(Role::reader, id);
    if (id == 7) reader.qos.reliability = Reliability::reliable;
    negotiation.endpoint_seen(reader);
  }
  const Serving serving = negotiation.serving(100);
  ASSERT_EQ(serving.udp.size(), 2U);
  for (const Route& route : serving.udp) EXPECT_EQ(route.reliable, route.reader == 7);

  Endpoint ours = endpoint(Role::reader, 200);
  ours.qos.reliability = Reliability::reliable;
  negotiation.local_added(ours, type);
  for (const Hearing& hearing : negotiation.hearing(200)) EXPECT_TRUE(hearing.source.reliable);
  EXPECT_EQ(negotiation.hearing(200).size(), 1U);
}

TEST_F(NegotiationTest, AMaximumRateTravelsInRequestsAndIsInForceInRoutes) {
  our_reader();
  EXPECT_TRUE(negotiation.rate_changed(200, 100'000));
  EXPECT_FALSE(negotiation.rate_changed(200, 100'000));
  EXPECT_EQ(negotiation.local(200)->request.min_period_us, 100'000U);
  EXPECT_EQ(negotiation.local(200)->request.sequence, 2U);

  our_writer();
  negotiation.endpoint_seen(endpoint(Role::reader, 7));
  Request slower = request(7, 2, F::data);
  slower.min_period_us = 50'000;
  negotiation.request_received(slower);
  const Serving serving = negotiation.serving(100);
  const auto route =
      std::find_if(serving.udp.begin(), serving.udp.end(), [](auto& r) { return r.reader == 7; });
  ASSERT_NE(route, serving.udp.end());
  EXPECT_EQ(route->min_period_us, 50'000U);
  EXPECT_EQ(serving.readers.at(0).max_rate_hz, 20);
}

TEST_F(NegotiationTest, AttachmentsEndWithTheMemoryTheyWereIn) {
  our_reader();
  negotiation.connection_changed(200, 7, TransportKind::shm, true);
  const std::uint64_t before = negotiation.local(200)->request.sequence;
  at_host(token(9));
  EXPECT_TRUE(negotiation.local(200)->request.attached.empty());
  EXPECT_GT(negotiation.local(200)->request.sequence, before);
}

TEST_F(NegotiationTest, WriterAndReaderOfOneNodeMatchLikeAnyOthers) {
  our_writer();
  our_reader();
  EXPECT_EQ(negotiation.serving(100).udp.size(), 1U);
  EXPECT_TRUE(negotiation.serving(100).shm_port);
  negotiation.connection_changed(200, 100, TransportKind::shm, true);
  EXPECT_EQ(negotiation.serving(100).shm.size(), 1U);
}

TEST_F(NegotiationTest, EntriesBeyondTheLimitAreIgnoredAndCounted) {
  Negotiation small({.endpoints = 2, .forget_lost_after = 60s});
  for (EndpointId id = 1; id <= 4; ++id) small.endpoint_seen(endpoint(Role::reader, id));
  for (EndpointId id = 11; id <= 14; ++id) small.request_received(request(id, 1, F::data));
  EXPECT_EQ(small.endpoints(), 2U);
  EXPECT_EQ(small.ignored(), 4U);
}

TEST_F(NegotiationTest, OfTooManyRequestsOfReadersThatHaveNotComeTheOldestMakesRoom) {
  Negotiation small({.endpoints = 2, .forget_lost_after = 60s});
  small.local_added(endpoint(Role::writer, 100), type);
  for (const EndpointId id : {90, 91, 7, 8}) small.request_received(request(id, 2, F::data));
  small.endpoint_seen(endpoint(Role::reader, 7));
  EXPECT_EQ(small.serving(100).udp.at(0).mask, FieldMask(F::data));
}

// Whatever the order in which announcement, requests and shared memory come: once all came, the outcome is
// the same.
TEST_F(NegotiationTest, TheOutcomeDoesNotDependOnTheOrderOfEvents) {
  std::random_device entropy;
  const auto seed = entropy();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  std::vector<int> events{0, 1, 2, 3, 4, 5};
  for (int round = 0; round < 2000; ++round) {
    std::shuffle(events.begin(), events.end(), random);
    Negotiation n;
    for (const int event : events) {
      if (event == 0) n.self_changed({.host = token(1), .network = here, .shm_state = ""});
      if (event == 1) n.local_added(endpoint(Role::writer, 100), type);
      if (event == 2) n.endpoint_seen(endpoint(Role::reader, 7, here, 1));
      if (event == 3) n.request_received(request(7, 2, F::data));
      if (event == 4) n.request_received(request(7, 3, F::width, {100}));
      if (event == 5) n.endpoint_seen(endpoint(Role::reader, 8));
    }
    const Serving serving = n.serving(100);
    ASSERT_EQ(serving.shm.size(), 1U);
    ASSERT_EQ(serving.shm[0].mask, FieldMask(F::width | F::width));
    ASSERT_EQ(serving.udp.size(), 1U);
    ASSERT_EQ(serving.udp[0].reader, 8U);
  }
}

}  // namespace
}  // namespace sft::core
