// The negotiation as a pure function of events. Its results are the routes of each writer of this node, and
// the connections of each of its readers.
#include "core/negotiation/negotiation.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "sft/msg_text.h"
#include "tests/support/test_seed.h"
#include "tests/unit/core/negotiation/negotiation_fixture.h"

namespace sft::core {
namespace {

using namespace std::chrono_literals;

TEST_F(NegotiationTest, AWriterWithoutReadersServesNobody) {
  our_writer();
  const Serving serving = negotiation.serving(100);
  EXPECT_TRUE(serving.network.empty());
  EXPECT_TRUE(serving.memory.empty());
  EXPECT_FALSE(serving.memory_port);
}

TEST_F(NegotiationTest, AReaderOnAnotherHostIsServedByUdpWithTheMaskOfItsFirstRequest) {
  our_writer();
  negotiation.endpoint_seen(endpoint(Role::reader, 7));
  const Serving serving = negotiation.serving(100);
  ASSERT_EQ(serving.network.size(), 1U);
  EXPECT_EQ(serving.network[0].selection.mask(), FieldMask(F::height | F::width));
  EXPECT_EQ(std::get<UdpAddress>(serving.network[0].destination).ip, 0x0a000001U);
  EXPECT_EQ(serving.readers[0].reason, "another host");
  EXPECT_FALSE(serving.memory_port);
}

TEST_F(NegotiationTest, AReaderOfPartsIsServedWithTheseAndWithTheFieldsThatTheyNeed) {
  our_writer();
  Endpoint reader = endpoint(Role::reader, 7);
  const Selection wanted = type.parse_selection("header.stamp, data{x,y}[::4]").value();
  reader.request.mask_words = wanted.mask().to_words();
  reader.request.parts = wanted.to_bytes();
  negotiation.endpoint_seen(reader);
  const Serving serving = negotiation.serving(100);
  ASSERT_EQ(serving.network.size(), 1U);
  EXPECT_EQ(serving.network[0].selection, type.closed(wanted));
  EXPECT_EQ(serving.readers[0].mask, type.closed(wanted).mask());
}

TEST_F(NegotiationTest, AReaderThatChangesItsPartsIsServedWithTheNewOnesAndOthersWithTheirs) {
  const auto window_of = [&](EndpointId reader, int begin) {
    Request wish = request(reader, static_cast<std::uint64_t>(begin), F::height | F::width);
    const Selection wanted = type.parse_selection("height, data[" + std::to_string(begin) + ":100]").value();
    wish.mask_words = wanted.mask().to_words();
    wish.parts = wanted.to_bytes();
    return wish;
  };
  our_writer();
  for (const EndpointId id : {7, 8}) {
    Endpoint reader = endpoint(Role::reader, id);
    reader.request = window_of(id, 1);
    negotiation.endpoint_seen(reader);
  }
  for (int begin = 2; begin < 50; ++begin) {
    ASSERT_TRUE(negotiation.request_received(window_of(7, begin)));
    const std::vector<Route> routes = negotiation.serving(100).network;
    ASSERT_EQ(routes.size(), 2U);
    for (const Route& route : routes) {
      const auto place = route.selection.parts()[0].columns.begin;
      ASSERT_EQ(place, route.reader == 7 ? static_cast<std::uint32_t>(begin) : 1U) << route.reader;
    }
  }
}

TEST_F(NegotiationTest, AReaderIsNotServedIfItsPartsOrConditionsAreMalformed) {
  our_writer();
  const Selection part = type.parse_selection("data{x}").value();
  std::vector<std::byte> of_no_leaf = part.to_bytes();
  of_no_leaf[4] = std::byte{100};
  // Conditions on a list and on a string, which the text form of a selection cannot contain.
  const auto on = [&](const char* field) {
    const auto leaf = static_cast<std::uint32_t>(*type.parse_mask(field).value().begin());
    const Selection::Gate gate{{{.kind = Selection::Condition::Kind::compare, .leaves = {leaf}}}, {}};
    return Selection::make(type.none(), {}, gate).value().to_bytes();
  };
  for (const std::vector<std::byte>& parts : {std::vector<std::byte>{std::byte{255}},
                                              {std::byte{1}},
                                              of_no_leaf,
                                              on("data"),
                                              on("header.frame_id")}) {
    Endpoint reader = endpoint(Role::reader, 7);
    reader.request.parts = parts;
    negotiation.endpoint_seen(reader);
    const Serving serving = negotiation.serving(100);
    EXPECT_TRUE(serving.network.empty());
    ASSERT_EQ(serving.readers.size(), 1U);
    EXPECT_FALSE(serving.readers[0].served);
    EXPECT_EQ(serving.readers[0].reason.find("it asks for parts or conditions that do not fit the type"), 0U);
    negotiation.endpoint_departed(7);
  }
}

TEST_F(NegotiationTest, APartOfANumberIsNoneAtAll) {
  our_writer();
  Endpoint reader = endpoint(Role::reader, 7);
  const auto height = static_cast<std::uint32_t>(*type.find("height")->begin());
  const Selection::Part part{.leaf = height, .columns = {.step = 2}, .channels = {"x"}};
  reader.request.parts = Selection::make(FieldMask(F::width), {part}, {}).value().to_bytes();
  reader.request.mask_words = words(F::width);
  negotiation.endpoint_seen(reader);
  EXPECT_EQ(negotiation.serving(100).network[0].selection, Selection(FieldMask(F::height | F::width)));
}

TEST_F(NegotiationTest, APartThatIsMeantByAnotherLayoutRuleIsNotServedAndOtherRequestsAre) {
  const auto type_with = [](const std::string& comment) {
    return from_msg("my_msgs/Map", "uint32 w\nuint32 h\nuint8[] cells " + comment + "\n").value();
  };
  const DynamicType ours = type_with("# @sft_layout rows=h columns=w");
  const auto of_our_type = [&](Endpoint e) {
    e.type_name = ours.name();
    e.type_hash = ours.hash();
    e.request.mask_words = {4};
    return e;
  };
  negotiation.local_added(of_our_type(endpoint(Role::writer, 100)), ours.support());
  const auto serving = [&](const DynamicType& theirs, const char* selection) {
    Endpoint reader = of_our_type(endpoint(Role::reader, 7));
    const Selection asked = theirs.support().parse_selection(selection).value();
    if (!asked.is_mask()) reader.request.parts = asked.to_bytes();
    negotiation.endpoint_seen(reader);
    const PublisherStatus::Reader status = negotiation.serving(100).readers.at(0);
    negotiation.endpoint_departed(7);
    return status.served ? "" : status.reason;
  };
  EXPECT_EQ(serving(ours, "cells[1:]"), "");
  for (const char* comment : {"", "# @sft_layout columns=w", "# @sft_layout rows=w columns=h"}) {
    EXPECT_NE(
        serving(type_with(comment), "cells[1:]").find("the part of cells is meant by another layout rule"),
        std::string::npos)
        << comment;
    EXPECT_EQ(serving(type_with(comment), "cells"), "") << comment;
  }
}

TEST_F(NegotiationTest, EventsOfATopicThatIsNotOursChangeNothing) {
  our_writer();
  Endpoint reader = endpoint(Role::reader, 7);
  reader.topic = "another topic";
  EXPECT_FALSE(negotiation.endpoint_seen(reader));
  EXPECT_FALSE(negotiation.request_received(request(7, 2, F::data)));
  EXPECT_FALSE(negotiation.endpoint_lost(7, Time{}));
  EXPECT_FALSE(negotiation.endpoint_departed(7));
}

TEST_F(NegotiationTest, NothingIsSentToAReaderBeforeItSaysThatItListens) {
  our_writer();
  Endpoint reader = endpoint(Role::reader, 7);
  reader.request.listening.clear();
  negotiation.endpoint_seen(reader);
  EXPECT_TRUE(negotiation.serving(100).network.empty());
  EXPECT_EQ(negotiation.serving(100).readers.at(0).reason, "the subscriber is not listening yet");
  negotiation.request_received(request(7, 2, F::data));
  EXPECT_EQ(negotiation.serving(100).network.at(0).selection.mask(), FieldMask(F::data));
}

TEST_F(NegotiationTest, AReaderIsReachedInANetworkThatWeAreInToo) {
  our_writer();
  Endpoint reader = endpoint(Role::reader, 7);
  reader.addresses.push_back({0x0b000001, 7000, 1 << 20});
  negotiation.endpoint_seen(reader);
  const auto destination = [&] {
    return std::get<UdpAddress>(negotiation.serving(100).network.at(0).destination).ip;
  };
  EXPECT_EQ(destination(), 0x0a000001U);
  EXPECT_TRUE(negotiation.network_changed({}, {{0x0b000002, 24}}));
  EXPECT_EQ(destination(), 0x0b000001U);
}

TEST_F(NegotiationTest, OurEndpointsAreAnnouncedWithTheAddressesOfNow) {
  our_reader();
  const std::vector<UdpAddress> before{{0x0a000001, 7000, 1 << 20}}, after{{0x0b000001, 7000, 1 << 20}};
  EXPECT_EQ(negotiation.local(200)->addresses, before);
  negotiation.network_changed(after, {});
  EXPECT_EQ(negotiation.local(200)->addresses, after);
  our_writer();  // the writer is made with the former addresses
  EXPECT_EQ(negotiation.local(100)->addresses, after);
}

TEST_F(NegotiationTest, AReaderInTheSameNetworkStackIsReachedThroughLoopback) {
  our_writer();
  negotiation.endpoint_seen(endpoint(Role::reader, 7, here, 3));
  EXPECT_EQ(std::get<UdpAddress>(negotiation.serving(100).network.at(0).destination).ip, 0x7f000001U);
}

TEST_F(NegotiationTest, AReaderInTheSameNetworkStackThatHasOnlyIPv6IsReachedThroughThatLoopback) {
  our_writer();
  Endpoint reader = endpoint(Role::reader, 7, here, 3);
  reader.addresses = {{parse_ip_address("fd00::7").value(), 7000, 1 << 20}};
  negotiation.endpoint_seen(reader);
  EXPECT_EQ(std::get<UdpAddress>(negotiation.serving(100).network.at(0).destination).ip, loopback_ipv6);
}

TEST_F(NegotiationTest, AReaderThatGetsAnotherAddressIsStillTheSame) {
  our_writer();
  Endpoint reader = endpoint(Role::reader, 7);
  reader.node_id = 70;
  negotiation.endpoint_seen(reader);
  const Serving before = negotiation.serving(100);
  reader.addresses = {{parse_ip_address("fd00::7").value(), 7000, 1 << 20}};
  negotiation.endpoint_seen(reader);
  const Serving after = negotiation.serving(100);
  UdpAddress moved = std::get<UdpAddress>(before.network.at(0).destination);
  EXPECT_EQ(moved.node, reader.node_id);
  moved.ip = reader.addresses[0].ip;
  EXPECT_EQ(std::get<UdpAddress>(after.network.at(0).destination), moved);
}

TEST_F(NegotiationTest, AReaderThatSharesMemoryIsServedByUdpUntilItIsAttachedAndThenByMemoryOnly) {
  our_writer();
  negotiation.endpoint_seen(endpoint(Role::reader, 7, here, 1));
  Serving serving = negotiation.serving(100);
  EXPECT_TRUE(serving.memory_port);
  EXPECT_EQ(serving.network.size(), 1U);
  EXPECT_TRUE(serving.memory.empty());

  negotiation.request_received(request(7, 2, F::height | F::width, {100}));
  serving = negotiation.serving(100);
  EXPECT_TRUE(serving.network.empty());
  ASSERT_EQ(serving.memory.size(), 1U);
  EXPECT_EQ(std::get<DoorbellAddress>(serving.memory[0].destination).page, 7U);
  EXPECT_EQ(serving.readers[0].reason, "same host");
}

TEST_F(NegotiationTest, AnAttachedReaderThatListensByUdpTooGetsThereWhatSharedMemoryDoesNotTake) {
  our_writer();
  negotiation.endpoint_seen(endpoint(Role::reader, 7, here, 1));
  negotiation.request_received(request(7, 2, F::height, {100}));
  const Serving serving = negotiation.serving(100);
  ASSERT_EQ(serving.fallback.size(), 1U);
  EXPECT_TRUE(serving.fallback[0].fallback);
  EXPECT_EQ(serving.fallback[0].selection.mask(), FieldMask(F::height));
  EXPECT_TRUE(std::holds_alternative<UdpAddress>(serving.fallback[0].destination));
  Request silent = request(7, 3, F::height, {100});
  silent.listening.clear();
  negotiation.request_received(silent);
  EXPECT_EQ(negotiation.serving(100).memory.size(), 1U);
  EXPECT_TRUE(negotiation.serving(100).fallback.empty());
}

TEST_F(NegotiationTest, WhenTheMemoryIsLostItsReadersAreServedByUdpAgain) {
  our_writer();
  negotiation.endpoint_seen(endpoint(Role::reader, 7, here, 1));
  negotiation.request_received(request(7, 2, F::height, {100}));
  at_host({});
  const Serving serving = negotiation.serving(100);
  EXPECT_TRUE(serving.memory.empty());
  EXPECT_EQ(serving.network.size(), 1U);
  EXPECT_EQ(serving.readers[0].reason, "no shared memory: off");
}

TEST_F(NegotiationTest, WhatIsToldLastOfAReaderHolds) {
  our_writer();
  Endpoint reader = endpoint(Role::reader, 7);
  negotiation.endpoint_seen(reader);
  const auto mask = [&] { return negotiation.serving(100).network.at(0).selection.mask(); };
  EXPECT_TRUE(negotiation.request_received(request(7, 5, F::data)));
  EXPECT_EQ(mask(), FieldMask(F::data));
  EXPECT_TRUE(negotiation.request_received(request(7, 4, F::height)));
  EXPECT_EQ(mask(), FieldMask(F::height)) << "the request before was not the reader's own";
  reader.request = request(7, 6, F::width);
  EXPECT_TRUE(negotiation.endpoint_seen(reader));
  EXPECT_EQ(mask(), FieldMask(F::width));
}

TEST_F(NegotiationTest, ARequestOfAReaderThatIsNotThereIsIgnored) {
  our_writer();
  EXPECT_FALSE(negotiation.request_received(request(7, 3, F::data)));
  EXPECT_TRUE(negotiation.serving(100).readers.empty());
}

TEST_F(NegotiationTest, WhatOthersSayOfAnEndpointOfOursIsIgnored) {
  our_reader();
  const Endpoint before = *negotiation.local(200);
  Endpoint other = endpoint(Role::reader, 200);
  other.topic = "elsewhere";
  EXPECT_FALSE(negotiation.endpoint_seen(other));
  EXPECT_FALSE(negotiation.request_received(request(200, 9, F::data)));
  EXPECT_FALSE(negotiation.endpoint_lost(200, Time{}));
  EXPECT_FALSE(negotiation.endpoint_departed(200));
  ASSERT_NE(negotiation.local(200), nullptr);
  EXPECT_EQ(*negotiation.local(200), before);
}

TEST_F(NegotiationTest, ALostReaderIsNotServedUntilItReturns) {
  our_writer();
  negotiation.endpoint_seen(endpoint(Role::reader, 7));
  negotiation.request_received(request(7, 3, F::data));
  negotiation.endpoint_lost(7, Time{});
  EXPECT_TRUE(negotiation.serving(100).network.empty());
  EXPECT_EQ(negotiation.serving(100).readers.at(0).reason, "its node does not answer");
  EXPECT_FALSE(negotiation.request_received(request(7, 4, F::height)));
  Endpoint returned = endpoint(Role::reader, 7);
  returned.request = request(7, 5, F::width);
  negotiation.endpoint_seen(returned);
  EXPECT_EQ(negotiation.serving(100).network.at(0).selection.mask(), FieldMask(F::width));
}

TEST_F(NegotiationTest, ALostReaderIsForgottenAfterAWhileAndADepartedOneAtOnce) {
  our_writer();
  negotiation.endpoint_seen(endpoint(Role::reader, 7));
  negotiation.endpoint_seen(endpoint(Role::reader, 8));
  negotiation.endpoint_departed(8);
  negotiation.endpoint_lost(7, Time{});
  EXPECT_FALSE(negotiation.tick(Time{} + 59s));
  EXPECT_EQ(negotiation.serving(100).readers.size(), 1U);
  EXPECT_TRUE(negotiation.tick(Time{} + 60s));
  EXPECT_TRUE(negotiation.serving(100).readers.empty());
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
  EXPECT_TRUE(negotiation.serving(100).samples_assert);
  Request slower = request(8, 2, F::data);
  slower.min_period_us = 1;
  negotiation.request_received(slower);
  EXPECT_FALSE(negotiation.serving(100).samples_assert);
}

TEST_F(NegotiationTest, AWriterWhoseNodeDoesNotAnswerIsHeardOfAsNotAlive) {
  our_reader();
  negotiation.endpoint_seen(endpoint(Role::writer, 7));
  EXPECT_TRUE(negotiation.hearing(200).at(0).status.alive);
  negotiation.endpoint_lost(7, Time{});
  EXPECT_FALSE(negotiation.hearing(200).at(0).status.alive);
  EXPECT_EQ(negotiation.hearing(200).at(0).status.reason, "its node does not answer");
}

TEST_F(NegotiationTest, AWriterIsConnectedOnceOurReaderListensToItAndWhileItsNodeAnswers) {
  our_reader();
  negotiation.endpoint_seen(endpoint(Role::writer, 7));
  const auto heard = [&] { return negotiation.hearing(200).at(0).status; };
  EXPECT_TRUE(heard().matched);
  EXPECT_FALSE(heard().connected);
  negotiation.connection_changed(200, 7, true, false);
  EXPECT_TRUE(heard().connected);
  negotiation.endpoint_lost(7, Time{});
  EXPECT_TRUE(heard().matched);
  EXPECT_FALSE(heard().connected);
}

TEST_F(NegotiationTest, EveryChangeOfARequirementOrAnAttachmentIsANewerRequest) {
  our_reader();
  const std::uint64_t first = negotiation.local(200)->request.sequence;
  const Selection wanted(FieldMask(F::data | F::height));
  EXPECT_TRUE(negotiation.requirement_changed(200, {wanted}));
  EXPECT_FALSE(negotiation.requirement_changed(200, {wanted}));
  EXPECT_TRUE(negotiation.connection_changed(200, 7, false, true));
  EXPECT_FALSE(negotiation.connection_changed(200, 7, false, true));
  EXPECT_TRUE(negotiation.connection_changed(200, 7, true, true));
  EXPECT_TRUE(negotiation.requirement_changed(200, {wanted, 1000}));
  EXPECT_FALSE(negotiation.requirement_changed(200, {wanted, 1000}));
  const Request& asked = negotiation.local(200)->request;
  EXPECT_EQ(asked.sequence, first + 4);
  EXPECT_EQ(asked.attached, std::vector<EndpointId>{7});
  EXPECT_EQ(asked.listening.back(), 7U);
}

TEST_F(NegotiationTest, AHistoryBeginsAgainOnceOurReaderListensToTheWriterNoMore) {
  our_reader();
  negotiation.connection_changed(200, 7, true, true);
  EXPECT_TRUE(negotiation.history_began(200, 7));
  EXPECT_FALSE(negotiation.history_began(200, 7));
  negotiation.connection_changed(200, 7, true, false);
  EXPECT_EQ(negotiation.local(200)->request.begun, std::vector<EndpointId>{7}) << "it came over the network";
  negotiation.connection_changed(200, 7, false, false);
  EXPECT_TRUE(negotiation.local(200)->request.begun.empty());
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
  ASSERT_EQ(serving.network.size(), 2U);
  for (const Route& route : serving.network) EXPECT_EQ(route.reliable, route.reader == 7);

  Endpoint ours = endpoint(Role::reader, 200);
  ours.qos.reliability = Reliability::reliable;
  negotiation.local_added(ours, type);
  for (const Hearing& hearing : negotiation.hearing(200)) EXPECT_TRUE(hearing.source.reliable);
  EXPECT_EQ(negotiation.hearing(200).size(), 1U);
}

TEST_F(NegotiationTest, AMaximumRateTravelsInRequestsAndIsInForceInRoutes) {
  our_reader();
  const Wanted slow{FieldMask(F::data), 100'000};
  EXPECT_TRUE(negotiation.requirement_changed(200, slow));
  EXPECT_FALSE(negotiation.requirement_changed(200, slow));
  EXPECT_EQ(negotiation.local(200)->request.min_period_us, 100'000U);
  EXPECT_EQ(negotiation.local(200)->request.sequence, 2U);

  our_writer();
  negotiation.endpoint_seen(endpoint(Role::reader, 7));
  Request slower = request(7, 2, F::data);
  slower.min_period_us = 50'000;
  negotiation.request_received(slower);
  const Serving serving = negotiation.serving(100);
  const auto route =
      std::find_if(serving.network.begin(), serving.network.end(), [](auto& r) { return r.reader == 7; });
  ASSERT_NE(route, serving.network.end());
  EXPECT_EQ(route->min_period_us, 50'000U);
  EXPECT_EQ(serving.readers.at(0).max_rate_hz, 20);
}

TEST_F(NegotiationTest, AttachmentsEndWithTheMemoryTheyWereIn) {
  our_reader();
  for (const EndpointId writer : {7U, 8U}) negotiation.connection_changed(200, writer, false, true);
  const std::uint64_t before = negotiation.local(200)->request.sequence;
  at_host(token(9));
  EXPECT_TRUE(negotiation.local(200)->request.attached.empty());
  EXPECT_EQ(negotiation.local(200)->request.sequence, before + 1) << "one newer request";
  at_host(token(10));
  EXPECT_EQ(negotiation.local(200)->request.sequence, before + 1) << "nothing was attached";
}

// Endpoints and shared memory may appear in any order. Once all of them have appeared, the outcome is the
// same for each order.
TEST_F(NegotiationTest, TheOutcomeDoesNotDependOnTheOrderOfEvents) {
  SCOPED_TRACE(test::how_to_repeat());
  test::Random random{test::test_seed()};
  std::vector<int> events{0, 1, 2, 3};
  for (int round = 0; round < 2000; ++round) {
    std::shuffle(events.begin(), events.end(), random);
    Negotiation n;
    for (const int event : events) {
      if (event == 0) n.self_changed({.host = token(1), .network = here, .memory_state = ""});
      if (event == 1) n.local_added(endpoint(Role::writer, 100), type);
      if (event == 2) n.endpoint_seen(endpoint(Role::reader, 7, here, 1));
      if (event == 2) n.request_received(request(7, 2, F::data));
      if (event == 2) n.request_received(request(7, 3, F::width, {100}));
      if (event == 3) n.endpoint_seen(endpoint(Role::reader, 8));
    }
    const Serving serving = n.serving(100);
    ASSERT_EQ(serving.memory.size(), 1U);
    ASSERT_EQ(serving.memory[0].selection.mask(), FieldMask(F::width | F::width));
    ASSERT_EQ(serving.network.size(), 1U);
    ASSERT_EQ(serving.network[0].reader, 8U);
  }
}

}  // namespace
}  // namespace sft::core
