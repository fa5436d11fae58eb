// Tests which samples count as lost and which as withheld if the subscriber has conditions.
#include <gmock/gmock.h>

#include "core/seam/gate_table.h"
#include "tests/unit/core/subscribe/intake_fixture.h"

namespace sft::core {
namespace {

using ::testing::ElementsAre;

class GatedIntakeTest : public IntakeTest {
 protected:
  static constexpr std::uint64_t conditions = 77;

  /// Returns a sample that names its number among the samples that passed the gate. If `ordinal` is 0, it
  /// names no number.
  SampleHandle passed(const Sent& sent, std::uint32_t ordinal, std::uint64_t of_conditions = conditions) {
    const auto gate = std::make_shared<Gate>(0, detail::Conditions(), of_conditions);
    SampleHandle made = sample(sent);
    made->header() = {};
    for (std::uint32_t i = 0; i < ordinal; ++i) gate->consider(detail::FieldSource::of_nothing(), i);
    if (ordinal != 0) write_gate_table(*made, 0, std::vector{gate});
    return made;
  }
  void ask(std::uint64_t hash) { intake->accounts().ask_conditions(hash); }
  /// Makes all samples of earlier requests count as no longer under way.
  void settle() {
    WriterAccounts& accounts = intake->accounts();
    accounts.forget_conditions_before(accounts.asked_gates().latest());
  }
};

TEST_F(GatedIntakeTest, WhatTheNumbersSkipIsLostAndTheRestWasWithheld) {
  ask(conditions);
  memory.push_back(passed({.sequence = 1}, 1));
  memory.push_back(passed({.sequence = 5}, 2));
  memory.push_back(passed({.sequence = 9}, 5));
  EXPECT_THAT(taken(), ElementsAre(1, 5, 9));
  EXPECT_EQ(status().lost, 2U);
  EXPECT_EQ(status().withheld, 3U + 1U);
}

TEST_F(GatedIntakeTest, WhatIsMissingBetweenSamplesOfDifferentGatesCountsAsWithheld) {
  ask(conditions);
  memory.push_back(passed({.sequence = 1}, 1));
  memory.push_back(passed({.sequence = 4}, 7, 78));
  EXPECT_THAT(taken(), ElementsAre(1, 4));
  EXPECT_EQ(status().withheld, 2U) << "the second one came before its writer knew of the conditions";
  ask(78);
  memory.push_back(passed({.sequence = 9}, 8, 78));
  memory.push_back(passed({.sequence = 12}, 9, 78));
  EXPECT_THAT(taken(), ElementsAre(9, 12));
  ask(0);
  memory.push_back(passed({.sequence = 15}, 10, 78));
  in_memory({.sequence = 18});
  EXPECT_THAT(taken(), ElementsAre(15, 18)) << "samples of former conditions are taken";
  EXPECT_EQ(status().lost, 0U);
  in_memory({.sequence = 20});
  EXPECT_THAT(taken(), ElementsAre(20));
  EXPECT_EQ(status().lost, 1U) << "without conditions each one that is missing is lost";
}

TEST_F(GatedIntakeTest, WhatIsMissingAroundConditionsUnderWhichNothingCameCountsAsWithheld) {
  in_memory({.sequence = 1});
  EXPECT_THAT(taken(), ElementsAre(1));
  ask(conditions);
  ask(0);
  in_memory({.sequence = 5});
  EXPECT_THAT(taken(), ElementsAre(5));
  EXPECT_EQ(status().lost, 0U);
  EXPECT_EQ(status().withheld, 3U);
  in_memory({.sequence = 7});
  EXPECT_THAT(taken(), ElementsAre(7));
  EXPECT_EQ(status().lost, 1U) << "conditions are over";
}

TEST_F(GatedIntakeTest, NothingIsLostWhereTheWriterHasForgottenTheGateAndCountsAnew) {
  ask(conditions);
  memory.push_back(passed({.sequence = 1}, 5));
  memory.push_back(passed({.sequence = 9}, 1));
  memory.push_back(passed({.sequence = 12}, 3));
  EXPECT_THAT(taken(), ElementsAre(1, 9, 12));
  EXPECT_EQ(status().lost, 1U) << "number 2";
  EXPECT_EQ(status().withheld, 7U + 1U);
}

TEST_F(GatedIntakeTest, ASampleThatNamesTwoOfTheSubscribersGatesHasNoNumber) {
  ask(conditions);
  memory.push_back(passed({.sequence = 1}, 1));
  EXPECT_THAT(taken(), ElementsAre(1));
  ask(78);
  const std::vector gates{std::make_shared<Gate>(0, detail::Conditions(), conditions),
                          std::make_shared<Gate>(0, detail::Conditions(), 78)};
  for (const std::uint64_t sequence : {5U, 9U}) {
    SampleHandle both = sample({.sequence = sequence});
    both->header() = {};
    for (std::uint64_t i = 0; i < sequence; ++i) {
      for (const auto& gate : gates) gate->consider(detail::FieldSource::of_nothing(), 0);
    }
    write_gate_table(*both, 0, gates);
    memory.push_back(both);
  }
  EXPECT_THAT(taken(), ElementsAre(5, 9));
  EXPECT_EQ(status().lost, 0U) << "nobody knows which gate has withheld the others";
}

// Between the two samples the reader asked for other conditions, for which no sample arrived.
TEST_F(GatedIntakeTest, WhatOtherConditionsCanHaveWithheldBetweenTwoSamplesOfOneGateIsNotLost) {
  ask(conditions);
  memory.push_back(passed({.sequence = 1}, 1));
  EXPECT_THAT(taken(), ElementsAre(1));
  ask(78);
  ask(conditions);
  memory.push_back(passed({.sequence = 5}, 4));
  EXPECT_THAT(taken(), ElementsAre(5));
  EXPECT_EQ(status().lost, 0U) << "numbers 2 and 3 passed for other readers";
  EXPECT_EQ(status().withheld, 3U);
  settle();
  memory.push_back(passed({.sequence = 6}, 5));
  memory.push_back(passed({.sequence = 9}, 7));
  EXPECT_THAT(taken(), ElementsAre(6, 9));
  EXPECT_EQ(status().lost, 1U) << "number 6";
}

// The request reaches the writer late: the first two samples were sent before that.
TEST_F(GatedIntakeTest, ConditionsThatAreTakenBackBeforeAnythingComesUnderThemLoseNothing) {
  ask(0);
  in_memory({.sequence = 1});
  EXPECT_THAT(taken(), ElementsAre(1));
  ask(conditions);
  ask(0);
  in_memory({.sequence = 2});
  in_memory({.sequence = 5});
  in_memory({.sequence = 8});
  EXPECT_THAT(taken(), ElementsAre(2, 5, 8));
  EXPECT_EQ(status().lost, 0U);
  EXPECT_EQ(status().withheld, 4U);
  settle();
  in_memory({.sequence = 9});
  in_memory({.sequence = 12});
  EXPECT_THAT(taken(), ElementsAre(9, 12));
  EXPECT_EQ(status().lost, 2U);
}

// Samples that passed the conditions are for the reader, before and after its request reaches the writer.
TEST_F(GatedIntakeTest, WhatHasPassedTheFirstConditionsIsLostWhetherTheyWereInForceOrNot) {
  ask(0);
  in_memory({.sequence = 1});
  ask(conditions);
  memory.push_back(passed({.sequence = 2}, 6));
  memory.push_back(passed({.sequence = 6}, 8));
  EXPECT_THAT(taken(), ElementsAre(1, 2, 6));
  EXPECT_EQ(status().lost, 1U) << "number 7";
  EXPECT_EQ(status().withheld, 2U);
}

// Samples that passed the reader's former conditions arrive at the reader even if they are sent for another
// reader of the process.
TEST_F(GatedIntakeTest, WhoAsksForAllLosesWhatIsMissingBetweenSamplesThatPassedTheConditionsOfOthers) {
  ask(conditions);
  ask(0);
  settle();
  const auto for_another = [&](std::uint64_t sequence, std::uint32_t ordinal) {
    over_network({.sequence = sequence});
    network.back()->gate = gate_id(conditions, 0);
    network.back()->ordinal = ordinal;
  };
  for_another(9, 2);
  for_another(39, 17);
  over_network({.sequence = 42});
  EXPECT_THAT(taken(), ElementsAre(9, 39, 42));
  EXPECT_EQ(status().lost, 29U + 2U);
  EXPECT_EQ(status().withheld, 0U);
}

TEST_F(GatedIntakeTest, ASampleInSharedMemoryThatNamesAGateDoesNotEndItsConditions) {
  ask(conditions);
  ask(0);
  memory.push_back(passed({.sequence = 1}, 1));
  memory.push_back(passed({.sequence = 5}, 3));
  EXPECT_THAT(taken(), ElementsAre(1, 5));
  EXPECT_EQ(status().lost, 1U) << "number 2";
  EXPECT_EQ(status().withheld, 2U);
}

TEST_F(GatedIntakeTest, FormerConditionsAreForgottenOnceNoSampleOfThemIsUnderWay) {
  ask(conditions);
  memory.push_back(passed({.sequence = 1}, 1));
  EXPECT_THAT(taken(), ElementsAre(1));
  ask(0);
  settle();
  memory.push_back(passed({.sequence = 2}, 2));  // this sample passed the same gate, which other readers have
  memory.push_back(passed({.sequence = 5}, 3));
  EXPECT_THAT(taken(), ElementsAre(2, 5));
  EXPECT_EQ(status().lost, 2U);
}

TEST_F(GatedIntakeTest, ASampleThatNamesNoGateKeepsToTheRateOfItsReader) {
  intake->accounts().ask(1'000'000);
  ask(conditions);
  for (const std::uint64_t sequence : {1U, 2U, 3U, 4U})
    memory.push_back(passed({.sequence = sequence, .stamp_ns = static_cast<std::int64_t>(sequence)}, 0));
  EXPECT_EQ(taken().size(), 1U) << "the gate of its rate begins with as much";
  EXPECT_EQ(status().lost, 0U);
}

TEST_F(GatedIntakeTest, DoesNotWaitForADivertedSampleThatWasWithheld) {
  hear(9);
  ask(conditions);
  memory.push_back(passed({.sequence = 1}, 1));
  EXPECT_THAT(taken(), ElementsAre(1));
  memory.push_back(passed({.sequence = 3, .diverted = 2, .diverted_ns = now_ns}, 2));
  EXPECT_EQ(decide(), Decision::deliver);
}

TEST_F(GatedIntakeTest, RetainedSamplesPassNoGateAndHaveNoNumbers) {
  ask(conditions);
  const auto by_udp = [&](std::uint64_t sequence, std::uint32_t ordinal) {
    over_network({.sequence = sequence});
    network.back()->gate = gate_id(conditions, 0);
    network.back()->ordinal = ordinal;
  };
  for (const std::uint64_t retained : {4U, 5U, 6U}) by_udp(retained, 0);
  by_udp(9, 12);
  by_udp(12, 14);
  EXPECT_THAT(taken(), ElementsAre(4, 5, 6, 9, 12));
  EXPECT_EQ(status().lost, 1U) << "number 13";
  EXPECT_EQ(status().withheld, 2U + 1U);
}

/// Retained samples have no numbers that would show if a sample was lost or withheld.
TEST_F(GatedIntakeTest, ARetainedSampleThatIsMissingMayHaveBeenWithheldByConditions) {
  ask(conditions);
  for (const std::uint64_t retained : {4U, 6U}) {
    over_network({.sequence = retained});
    network.back()->gate = gate_id(conditions, 0);
    network.back()->oldest_retained = 4;
  }
  EXPECT_THAT(taken(), ElementsAre(4, 6));
  EXPECT_EQ(status().lost, 0U);
  EXPECT_EQ(status().withheld, 1U);
}

TEST_F(GatedIntakeTest, ARetainedSampleThatIsMissingIsLostToAReaderWithoutConditions) {
  ask(0);
  for (const std::uint64_t retained : {4U, 6U}) {
    over_network({.sequence = retained});
    network.back()->oldest_retained = 4;
  }
  EXPECT_THAT(taken(), ElementsAre(4, 6));
  EXPECT_EQ(status().lost, 1U);
}

}  // namespace
}  // namespace sft::core
