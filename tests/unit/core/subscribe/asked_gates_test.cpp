// Tests which of a reader's requests a writer may have had in force between two samples.
#include "core/subscribe/asked_gates.h"

#include <gmock/gmock.h>

#include <optional>
#include <vector>

namespace sft::core {
namespace {

constexpr std::uint64_t near = 7, far = 8;
using ::testing::ElementsAre;

AskedGates asked(const std::vector<std::uint64_t>& gates) {
  AskedGates asked;
  for (const std::uint64_t gate : gates) asked.ask(gate);
  return asked;
}

TEST(AskedGatesTest, BeforeAnythingIsAskedForThereAreNoConditions) {
  EXPECT_EQ(AskedGates().only_gate_since(0), 0U);
  EXPECT_EQ(asked({near}).only_gate_since(0), near) << "what is asked for first has always been so";
}

TEST(AskedGatesTest, OfVeryManyRequestsTheFirstOnesAreForgottenAndWhatTheyAskedForIsNotKnown) {
  AskedGates gates;
  for (int i = 0; i < 10'000; ++i) gates.ask(0, i % 2 == 0);
  EXPECT_EQ(gates.only_gate_since(0), std::nullopt);
  EXPECT_EQ(gates.only_gate_since(9'999), 0U);
}

TEST(AskedGatesTest, EachRequestSinceThenCanHaveBeenInForce) {
  const AskedGates gates = asked({0, near, far});
  EXPECT_EQ(asked({0, near}).only_gate_since(0), near);
  EXPECT_EQ(gates.only_gate_since(0), std::nullopt);
  EXPECT_EQ(gates.only_gate_since(1), std::nullopt);
  EXPECT_EQ(gates.only_gate_since(2), far);
  EXPECT_EQ(asked({near, 0, near}).only_gate_since(0), near);
  EXPECT_EQ(asked({near, far, near}).only_gate_since(0), std::nullopt);
}

TEST(AskedGatesTest, TheSameAskedAgainIsNoChange) {
  AskedGates gates = asked({near, near, near});
  gates.settle(gates.latest());
  EXPECT_EQ(gates.settled(), 0U);
}

TEST(AskedGatesTest, OnceTheRequestsHaveSettledOnlyTheLastOneIsInForce) {
  AskedGates gates = asked({near, far, near});
  EXPECT_EQ(gates.settled(), 0U);
  gates.settle(gates.latest());
  EXPECT_EQ(gates.settled(), 2U);
  EXPECT_EQ(gates.only_gate_since(gates.settled()), near);
  EXPECT_EQ(gates.only_gate_since(0), std::nullopt) << "for what came before, others can have been";
}

TEST(AskedGatesTest, RequestsThatCameMeanwhileDoNotSettle) {
  AskedGates gates = asked({near, far});
  const AskedGates::Number present = gates.latest();
  gates.ask(near);
  gates.settle(present);
  EXPECT_EQ(gates.settled(), 1U);
  EXPECT_THAT(gates.nameable(), ElementsAre(near, far));
  gates.settle(0);
  EXPECT_EQ(gates.settled(), 1U) << "it does not go back";
  for (std::uint64_t i = 0; i < 100; ++i) gates.ask(1 + i % 2);
  gates.settle(2);
  EXPECT_EQ(gates.settled(), 2U) << "also where that one was forgotten";
  EXPECT_EQ(gates.only_gate_since(gates.settled()), std::nullopt);
}

TEST(AskedGatesTest, FindsTheFirstRequestWithoutConditions) {
  const AskedGates gates = asked({near, 0, far, 0});
  EXPECT_EQ(gates.open_since(0), 1U);
  EXPECT_EQ(gates.open_since(1), 1U);
  EXPECT_EQ(gates.open_since(2), 3U);
  EXPECT_EQ(asked({near, far}).open_since(1), 1U) << "there is none";
}

// The memory of a sample may have no gate table. Then it is unknown if the sample has passed the first gates.
TEST(AskedGatesTest, FindsNoRequestBehindGatesThatSamplesNeedNotName) {
  AskedGates gates;
  for (std::uint64_t gate = 1; gate <= 9; ++gate) gates.ask(gate);
  gates.ask(0);
  EXPECT_EQ(gates.open_since(0), 0U) << "nobody looks for the first one any more";
  EXPECT_EQ(gates.open_since(1), 9U);
  for (std::uint64_t i = 0; i < 100; ++i) gates.ask(i % 2);
  EXPECT_EQ(gates.open_since(1), 1U) << "it was forgotten";
}

// A rate without conditions has its own numbering, but withholds samples that pass other gates.
TEST(AskedGatesTest, AMaximumRateBetweenConditionsCanHaveWithheldWhatPassedThem) {
  AskedGates gates = asked({near});
  gates.ask(0, true);
  EXPECT_EQ(gates.only_gate_since(0), std::nullopt);
  EXPECT_EQ(gates.only_gate_since(1), 0U);
  gates.ask(near);
  EXPECT_EQ(gates.only_gate_since(0), std::nullopt);
  EXPECT_EQ(gates.only_gate_since(2), near);
}

TEST(AskedGatesTest, AsksForAllWhereNoRequestHasConditionsOrAMaximumRate) {
  EXPECT_TRUE(AskedGates().asks_for_all_since(0)) << "before anything is asked for";
  AskedGates gates = asked({near, 0});
  EXPECT_FALSE(gates.asks_for_all_since(0));
  EXPECT_TRUE(gates.asks_for_all_since(1));
  gates.ask(0, true);
  EXPECT_FALSE(gates.asks_for_all_since(1));
  gates.ask(0);
  EXPECT_FALSE(gates.asks_for_all_since(2));
  EXPECT_TRUE(gates.asks_for_all_since(3));
  for (std::uint64_t gate = 1; gate < 100; ++gate) gates.ask(gate % 2);
  EXPECT_FALSE(gates.asks_for_all_since(3)) << "this one was forgotten";
}

TEST(AskedGatesTest, NamesTheLatestFirstAndNoneTwice) {
  AskedGates gates = asked({near, 0, far, near});
  EXPECT_THAT(gates.nameable(), ElementsAre(near, far));
  gates.settle(gates.latest());
  EXPECT_THAT(gates.nameable(), ElementsAre(near));
  gates.ask(0);
  EXPECT_THAT(gates.nameable(), ElementsAre(near));
  gates.settle(gates.latest());
  EXPECT_THAT(gates.nameable(), ElementsAre());
}

TEST(AskedGatesTest, WhereRequestsWereForgottenNothingIsKnown) {
  AskedGates gates;
  for (std::uint64_t i = 0; i < 1000; ++i) gates.ask(1 + i % 100);
  EXPECT_EQ(gates.only_gate_since(0), std::nullopt);
  EXPECT_EQ(gates.only_gate_since(999), 100U);
  gates.settle(gates.latest());
  EXPECT_EQ(gates.settled(), 999U);
}

}  // namespace
}  // namespace sft::core
