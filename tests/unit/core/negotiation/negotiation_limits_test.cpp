// A participant that announces endpoints without end costs other participants only little.
#include <gtest/gtest.h>

#include "tests/unit/core/negotiation/negotiation_fixture.h"

namespace sft::core {
namespace {

constexpr AnnouncerId flooder = 2;

class Limits : public NegotiationTest {
 protected:
  Endpoint of(AnnouncerId announcer, Endpoint endpoint) {
    endpoint.announcer = announcer;
    endpoint.node = announcer == honest ? "honest" : "flooder";
    return endpoint;
  }
  void flood(Role role, const std::string& topic) {
    for (EndpointId id = 1000; id < 11'000; ++id) {
      Endpoint made_up = of(flooder, endpoint(role, id));
      made_up.topic = topic.empty() ? "topic " + std::to_string(id) : topic;
      negotiation.endpoint_seen(made_up);
    }
  }
};

TEST_F(Limits, AReaderThatComesAfterTenThousandMadeUpOnesIsServed) {
  our_writer();
  flood(Role::reader, "");
  negotiation.endpoint_seen(of(honest, endpoint(Role::reader, 7)));
  EXPECT_EQ(negotiation.serving(100).network.size(), 1U);
  EXPECT_EQ(negotiation.table().size(), 4097U) << "with our own";
  EXPECT_GT(negotiation.take_refusals().at("flooder"), 5000U);
  EXPECT_TRUE(negotiation.take_refusals().empty()) << "they are told once";
}

TEST_F(Limits, NobodyGetsMoreThanItsShareOfACrowdedTopic) {
  our_writer();
  flood(Role::reader, "points");
  negotiation.endpoint_seen(of(honest, endpoint(Role::reader, 7)));
  const Serving serving = negotiation.serving(100);
  EXPECT_LE(serving.readers.size(), 257U);
  EXPECT_TRUE(std::ranges::any_of(serving.network, [](const Route& route) { return route.reader == 7; }));
}

TEST_F(Limits, AReaderListensToAWriterThatComesAfterTenThousandMadeUpOnes) {
  our_reader();
  flood(Role::writer, "points");
  negotiation.endpoint_seen(of(honest, endpoint(Role::writer, 7)));
  const auto heard = negotiation.hearing(200);
  const auto it = std::ranges::find_if(heard, [](const Hearing& h) { return h.source.writer == 7; });
  ASSERT_NE(it, heard.end());
  EXPECT_TRUE(it->network);
}

TEST_F(Limits, ANodeWithThousandsOfEndpointsIsKnownWhole) {
  for (EndpointId id = 1000; id < 4000; ++id) {
    Endpoint one = of(honest, endpoint(Role::writer, id));
    one.topic = "topic " + std::to_string(id);
    negotiation.endpoint_seen(one);
    ASSERT_NE(negotiation.table().known(id), nullptr);
  }
  EXPECT_EQ(negotiation.ignored(), 0U);
}

TEST_F(Limits, OurOwnEndpointsTakeNothingOfTheRoomForOthers) {
  Negotiation small({.endpoints = 2, .forget_lost_after = std::chrono::seconds(60)});
  for (EndpointId id = 100; id < 110; ++id) small.local_added(endpoint(Role::writer, id), type);
  for (EndpointId id = 1; id <= 3; ++id) small.endpoint_seen(endpoint(Role::reader, id));
  EXPECT_EQ(small.table().size(), 12U);
}

TEST_F(Limits, AReaderHearsTheWritersThatItHasKnownLongestAndThatAnswer) {
  our_reader();
  constexpr EndpointId first = 10'000;
  for (EndpointId i = 0; i < writers_per_reader_max + 2; ++i) {
    // The writer that is announced first has the greatest id.
    Endpoint writer = endpoint(Role::writer, first - i);
    writer.announcer = i / 50;
    ASSERT_TRUE(negotiation.endpoint_seen(writer));
  }
  const auto heard = [&](EndpointId id) {
    for (const Hearing& h : negotiation.hearing(200)) {
      if (h.source.writer == id) return h;
    }
    return Hearing{};
  };
  const EndpointId last = first - writers_per_reader_max - 1;
  EXPECT_TRUE(heard(first).network);
  EXPECT_FALSE(heard(last).network || heard(last + 1).network);
  EXPECT_EQ(heard(last).status.reason, "the subscriber hears as many publishers as one can, 1024");
  negotiation.endpoint_lost(first, Time{});
  EXPECT_FALSE(heard(first).network);
  EXPECT_TRUE(heard(last + 1).network);
  EXPECT_FALSE(heard(last).network);
}

TEST_F(Limits, OtherDefinitionsOfOurTypeAreComparedOnceAndOnlyTheFirstOfThem) {
  our_writer();
  our_reader();
  for (EndpointId id = 1000; id < 3000; ++id) {
    Endpoint other = endpoint(Role::reader, id);
    other.announcer = id / 50;
    other.type_hash = id;
    // The description is invalid, but only a comparison detects this.
    other.type_description = {std::byte{1}};
    negotiation.endpoint_seen(other);
    negotiation.tick(Time{});
    const std::uint64_t before = negotiation.definitions_compared();
    const Serving serving = negotiation.serving(100);
    EXPECT_LE(negotiation.definitions_compared() - before, 16U);
    if (id % 100 == 0) {
      EXPECT_NE(serving.readers.back().reason.find("two different definitions"), std::string::npos);
    }
  }
  EXPECT_LE(negotiation.definitions_compared(), 32U) << "each was compared once";
  EXPECT_GE(negotiation.definitions_compared(), 16U);
}

TEST_F(Limits, OtherDefinitionsOfOurTypeThatComeLaterAreComparedAfterATick) {
  our_writer();
  EndpointId next = 1000;
  for (const std::uint64_t compared : {16, 32, 48}) {
    for (const EndpointId end = next + 16; next < end; ++next) {
      Endpoint other = endpoint(Role::reader, next);
      other.type_hash = next;
      other.type_description = {std::byte{1}};
      negotiation.endpoint_departed(next - 16);
      negotiation.endpoint_seen(other);
    }
    negotiation.serving(100);
    EXPECT_EQ(negotiation.definitions_compared(), compared);
    negotiation.tick(Time{});
  }
}

class Comparisons : public NegotiationTest {
 protected:
  Endpoint definition(std::uint64_t n) {
    Endpoint other = endpoint(Role::reader, 1);
    other.type_hash = n;
    other.type_description = {std::byte{1}};
    return other;
  }
  /// Returns true if the result of the comparison was kept.
  bool compare(std::uint64_t n) {
    comparisons.refill();
    const std::uint64_t before = comparisons.compared();
    comparisons.compare(type, definition(n));
    return comparisons.compared() == before;
  }
  TypeComparisons comparisons;
};

TEST_F(Comparisons, TheOldestIsForgottenFirstAndTheOthersAreKept) {
  for (std::uint64_t n = 1; n <= 257; ++n) EXPECT_FALSE(compare(n));
  for (std::uint64_t n = 2; n <= 257; ++n) EXPECT_TRUE(compare(n)) << n;
  EXPECT_FALSE(compare(1));
}

// All results together have far more bytes than may be kept at the same time.
TEST_F(Comparisons, WhatWasForgottenLeavesRoomForOthers) {
  constexpr std::uint64_t made = 20'000, known = 256;
  for (std::uint64_t n = 1; n <= made; ++n) compare(n);
  for (std::uint64_t n = made - known + 1; n <= made; ++n) ASSERT_TRUE(compare(n)) << n;
}

TEST_F(Comparisons, NoMoreThanAFewAreMadeBetweenTwoRefills) {
  for (std::uint64_t n = 1; n <= 100; ++n) EXPECT_NE(comparisons.compare(type, definition(n)), nullptr);
  EXPECT_EQ(comparisons.compared(), 16U);
  comparisons.refill();
  EXPECT_NE(comparisons.compare(type, definition(100)), nullptr);
  EXPECT_EQ(comparisons.compared(), 17U);
}

}  // namespace
}  // namespace sft::core
