// The limits of the writers from which a reader receives, and of the definitions of a type that are
// compared.
#include <gtest/gtest.h>

#include "tests/unit/core/negotiation/negotiation_fixture.h"

namespace sft::core {
namespace {

using Limits = NegotiationTest;

TEST_F(Limits, AReaderHearsTheWritersThatItHasKnownLongestAndThatAnswer) {
  our_reader();
  constexpr EndpointId first = 10'000;
  for (EndpointId i = 0; i < writers_per_reader_max + 2; ++i) {
    // The writer that is announced first has the greatest id.
    Endpoint writer = endpoint(Role::writer, first - i);
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

TEST_F(Limits, OtherDefinitionsOfOurTypeAreComparedOnceAndFewAtATime) {
  our_writer();
  our_reader();
  for (EndpointId id = 1000; id < 3000; ++id) {
    Endpoint other = endpoint(Role::reader, id);
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

TEST_F(Comparisons, AreKeptUntilThereAreTooMany) {
  for (std::uint64_t n = 1; n <= 256; ++n) EXPECT_FALSE(compare(n));
  for (std::uint64_t n = 1; n <= 256; ++n) EXPECT_TRUE(compare(n)) << n;
  EXPECT_FALSE(compare(257));
  EXPECT_TRUE(compare(257));
  EXPECT_FALSE(compare(1));
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
