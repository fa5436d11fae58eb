// Maximum rates: which samples pass, and how a reader distinguishes withheld samples from lost ones.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "core/seam/gate.h"
#include "core/subscribe/sequence_account.h"
#include "tests/support/test_seed.h"

namespace sft::core {
namespace {

constexpr std::int64_t ms = 1'000'000;
constexpr std::int64_t now_ns = 1'700'000'000'123'456'789;

/// Returns the number of samples that pass in 10 s. The source has the given period and jitter, both in ms.
int passed_in_10_s(RateBudget budget, double source_ms, double jitter_ms, std::mt19937_64& random) {
  std::uniform_real_distribution<> jitter(-jitter_ms, jitter_ms);
  int passed = 0;
  for (double t = 0; t < 10'000; t += source_ms) {
    passed += budget.take(now_ns + static_cast<std::int64_t>((t + jitter(random)) * 1e6)) ? 1 : 0;
  }
  return passed;
}

class RateBudgetTest : public ::testing::Test {
 protected:
  std::mt19937_64 random{sft::test::test_seed()};
  ::testing::ScopedTrace trace{__FILE__, __LINE__, sft::test::how_to_repeat()};
};

TEST_F(RateBudgetTest, AFasterSourceIsThinnedToTheLimit) {
  for (const double source_ms : {1.0, 10.0, 30.0, 33.3, 99.0}) {
    for (const double jitter_ms : {0.0, source_ms / 3}) {
      const int passed = passed_in_10_s(RateBudget(100'000), source_ms, jitter_ms, random);
      EXPECT_GE(passed, 99) << source_ms;
      EXPECT_LE(passed, 102) << source_ms;
    }
  }
}

TEST_F(RateBudgetTest, ASourceAsFastAsTheLimitLosesNothingToItsJitter) {
  EXPECT_GE(passed_in_10_s(RateBudget(100'000), 100, 40, random), 98);
  EXPECT_EQ(passed_in_10_s(RateBudget(100'000), 150, 40, random), 67);
}

TEST_F(RateBudgetTest, WithoutALimitEverythingPasses) {
  EXPECT_EQ(passed_in_10_s(RateBudget(0), 1, 0, random), 10'000);
}

TEST_F(RateBudgetTest, InAnyNPeriodsAtMostNAndTwoSamplesPass) {
  std::vector<std::int64_t> passed;
  RateBudget budget(10'000);
  std::int64_t t = now_ns;
  for (int i = 0; i < 20'000; ++i) {
    t += random() % 100 == 0 ? 50 * ms : static_cast<std::int64_t>(random() % (3 * ms));
    if (budget.take(t)) passed.push_back(t);
  }
  for (std::size_t first = 0; first < passed.size(); ++first) {
    for (std::size_t n = 1; n < 20 && first + n < passed.size(); ++n) {
      const auto periods = (passed[first + n] - passed[first]) / (10 * ms) + 1;
      ASSERT_LE(n + 1, static_cast<std::size_t>(periods) + 2);
    }
  }
}

TEST_F(RateBudgetTest, ASampleThatPassesBehindALongPauseUsesOneOfTheTwoThatWereSaved) {
  RateBudget budget(100'000);
  budget.take(now_ns);
  const std::int64_t later_ns = now_ns + 3'600'000 * ms;
  budget.spend(later_ns);
  EXPECT_TRUE(budget.take(later_ns));
  EXPECT_FALSE(budget.take(later_ns));
}

TEST_F(RateBudgetTest, AClockThatIsSetBackHoldsNothingUp) {
  RateBudget budget(100'000);
  while (budget.take(now_ns)) {
  }
  EXPECT_FALSE(budget.take(now_ns - 3'600'000 * ms));
  EXPECT_TRUE(budget.take(now_ns - 3'600'000 * ms + 100 * ms));
}

// Because of this rule, a reader in shared memory takes all samples that its writer lets pass, although the
// two exchange no messages about the budget.
TEST_F(RateBudgetTest, WhoSeesNoMoreThanTheWriterLetPassTakesAllOfIt) {
  for (int round = 0; round < 200; ++round) {
    RateBudget writer(10'000);
    std::int64_t t = now_ns;
    const auto joins_at = random() % 200;
    RateBudget reader(10'000);
    for (std::size_t i = 0; i < 1000; ++i) {
      t += static_cast<std::int64_t>(random() % (15 * ms));
      const bool for_others_too = random() % 10 == 0;
      const bool passes = writer.take(t);
      if (i < joins_at || !(passes || for_others_too)) continue;
      const bool taken = reader.take(t);
      ASSERT_TRUE(taken || !passes);
    }
  }
}

TEST(RateGateTest, NumbersWhatPassesAndCountsWhatDoesNot) {
  Gate gate(100'000);
  std::uint32_t passed = 0;
  for (int i = 0; i < 1000; ++i) {
    gate.consider(detail::FieldSource::of_nothing(), now_ns + i * 10 * ms);
    passed += gate.passes() ? 1 : 0;
    EXPECT_EQ(gate.ordinal(), passed);
  }
  EXPECT_EQ(gate.withheld(), 1000 - passed);
}

class SequenceAccountTest : public ::testing::Test {
 protected:
  struct Arrival {
    SampleOrigin origin;
    RateKeeper keeper;
  };
  void enter(const Arrival& sample) {
    ASSERT_TRUE(is_new(sample));
    delivered += account.allows(sample.origin, sample.keeper) ? 1 : 0;
    const auto missing = account.enter(sample.origin, sample.keeper, {});
    lost += missing.lost;
    withheld += missing.withheld;
  }
  bool is_new(const Arrival& sample) const { return account.is_new(sample.origin); }
  void refuse(const Arrival& sample) { account.refuse(sample.origin); }
  static Arrival over_network(std::uint64_t sequence, std::uint32_t period = 0, std::uint32_t ordinal = 0) {
    return {{.sequence = sequence,
             .source_stamp_ns = stamp(sequence),
             .min_period_us = period,
             .ordinal = ordinal},
            RateKeeper::writer};
  }
  static Arrival by_memory(std::uint64_t sequence) {
    return {{.sequence = sequence, .source_stamp_ns = stamp(sequence)}, RateKeeper::reader};
  }
  /// Returns the timestamp of a sample of a source of 100 Hz.
  static std::int64_t stamp(std::uint64_t sequence) {
    return now_ns / (100 * ms) * (100 * ms) + static_cast<std::int64_t>(sequence) * 10 * ms;
  }

  SequenceAccount account;
  std::uint64_t delivered = 0;
  std::uint64_t lost = 0;
  std::uint64_t withheld = 0;
};

TEST_F(SequenceAccountTest, WithoutALimitEveryGapIsALoss) {
  for (const std::uint64_t sequence : {5U, 6U, 9U}) enter(over_network(sequence));
  enter(by_memory(20));
  EXPECT_EQ(lost, 12U);
  EXPECT_EQ(withheld, 0U);
}

TEST_F(SequenceAccountTest, WhatComesAgainOrTooLateIsNotNew) {
  enter(over_network(5));
  EXPECT_FALSE(is_new(over_network(5)));
  EXPECT_FALSE(is_new(by_memory(4)));
}

TEST_F(SequenceAccountTest, BeginsAnewWithTheSecondSampleInARowThatIsFarBehindOneThatNobodySent) {
  enter(by_memory(5));
  enter(over_network(0x7000'0000));
  const std::uint64_t lost_then = lost;
  EXPECT_FALSE(is_new(by_memory(6)));
  refuse(by_memory(6));
  enter(by_memory(7));
  enter(by_memory(8));
  EXPECT_EQ(lost, lost_then) << "nobody knows what the false number hid";
}

TEST_F(SequenceAccountTest, DoesNotBeginAnewForOneOldSampleOrForOnesThatAnotherPathBringsAgain) {
  enter(over_network(200'000));
  refuse(by_memory(7));
  refuse(by_memory(199'990));
  EXPECT_FALSE(is_new(by_memory(8)));
  refuse(by_memory(8));
  EXPECT_FALSE(is_new(by_memory(8))) << "the same sample again confirms nothing";
}

// Over UDP, lost and withheld samples are counted exactly, despite all losses and pauses.
TEST_F(SequenceAccountTest, OverUdpLostAndWithheldAreExact) {
  std::mt19937_64 random(sft::test::test_seed());
  SCOPED_TRACE(sft::test::how_to_repeat());
  for (int round = 0; round < 200; ++round) {
    account = {};
    lost = withheld = 0;
    Gate gate(20'000);
    // Counts between the first and the last sample that arrived.
    std::uint64_t passed_lost = 0, gate_withheld = 0;
    std::uint64_t lost_since = 0, withheld_since = 0;
    bool any = false;
    std::int64_t t = now_ns;
    for (std::uint64_t sequence = 1; sequence <= 500; ++sequence) {
      t += static_cast<std::int64_t>(random() % (random() % 50 == 0 ? 2000 * ms : 12 * ms));
      gate.consider(detail::FieldSource::of_nothing(), t);
      const bool comes = gate.passes() && random() % 3 != 0;
      if (!comes) {
        if (any) ++(gate.passes() ? lost_since : withheld_since);
        continue;
      }
      passed_lost += std::exchange(lost_since, 0);
      gate_withheld += std::exchange(withheld_since, 0);
      any = true;
      Arrival arrival = over_network(sequence, gate.min_period_us(), gate.ordinal());
      arrival.origin.source_stamp_ns = t;
      enter(arrival);
    }
    ASSERT_EQ(lost, passed_lost);
    ASSERT_EQ(withheld, gate_withheld);
  }
}

TEST_F(SequenceAccountTest, NumbersOfAGateMayTurnOver) {
  enter(over_network(10, 100'000, 0xffff'ffff));
  enter(over_network(30, 100'000, 1));
  EXPECT_EQ(lost, 1U);
  EXPECT_EQ(withheld, 18U);
}

TEST_F(SequenceAccountTest, InSharedMemoryTheReaderSkipsAndCountsThatAsWithheld) {
  account.ask(100'000);
  for (std::uint64_t sequence = 1; sequence <= 1000; ++sequence) enter(by_memory(sequence));
  EXPECT_NEAR(delivered, 100, 2);
  EXPECT_EQ(lost, 0U);
  EXPECT_EQ(withheld, 1000U - delivered);
}

TEST_F(SequenceAccountTest, BeginsWithOneSampleAndNotWithABurst) {
  account.ask(100'000);
  // All of these samples have stamps within one period.
  for (std::uint64_t sequence = 1; sequence <= 9; ++sequence) enter(by_memory(sequence));
  EXPECT_EQ(delivered, 1U);
}

// The writer's gate has used up its initial budget. The reader's budget must be used up, too, whichever
// path the samples took.
TEST_F(SequenceAccountTest, APathThatChangesToSharedMemoryBringsNoMoreThanTheLimit) {
  account.ask(100'000);
  enter(over_network(1, 100'000, 1));
  for (std::uint64_t sequence = 2; sequence <= 9; ++sequence) enter(by_memory(sequence));
  EXPECT_EQ(delivered, 1U);
  enter(over_network(11, 100'000, 2));
  for (std::uint64_t sequence = 12; sequence <= 49; ++sequence) enter(by_memory(sequence));
  EXPECT_EQ(delivered, 5U) << "one in each of the periods";
}

TEST_F(SequenceAccountTest, WhatAQueuePushedOutIsLostOnlyAsFarAsTheReaderWasEntitledToIt) {
  account.ask(100'000);
  for (std::uint64_t sequence = 1; sequence <= 30; ++sequence) enter(by_memory(sequence));
  enter(by_memory(38));  // within the same period as the samples before
  EXPECT_EQ(lost, 0U);
  enter(by_memory(138));  // ten periods later, two of which the budget has saved
  EXPECT_EQ(lost, 8U);
  EXPECT_EQ(delivered + lost + withheld, 138U);
}

TEST_F(SequenceAccountTest, WhereTheLimitChangesWhatIsMissingIsJudgedByTheSlowerOne) {
  enter(over_network(1, 100'000, 1));
  enter(over_network(11, 100'000, 2));
  enter(over_network(18));  // from here on there is no maximum rate
  enter(over_network(19));
  EXPECT_EQ(lost, 0U);
  enter(over_network(25, 100'000, 9));  // from here on the maximum rate applies again
  EXPECT_EQ(lost, 0U);
  EXPECT_EQ(withheld, 20U);
}

// The budget can save one period. A sample that was dropped by the queue may have used such a saved period.
TEST_F(SequenceAccountTest, UnderOneLimitWhatIsSavedOfItIsReckonedWith) {
  std::mt19937_64 random(sft::test::test_seed());
  SCOPED_TRACE(sft::test::how_to_repeat());
  account.ask(100'000);
  RateBudget budget(100'000, 1);
  std::uint64_t sequence = 1;
  enter(by_memory(sequence));
  budget.take(stamp(sequence));
  for (int i = 0; i < 1000; ++i) {
    const std::uint64_t gap = random() % 60;
    sequence += gap + 1;
    const std::uint64_t before = lost;
    const std::uint64_t forfeited = gap == 0 ? 0 : std::min(gap, budget.forfeited(stamp(sequence)));
    enter(by_memory(sequence));
    budget.take(stamp(sequence));
    ASSERT_EQ(lost - before, forfeited) << "behind a gap of " << gap;
  }
  EXPECT_GT(lost, 0U);
}

TEST_F(SequenceAccountTest, AnotherPathUnderTheSameLimitLosesNothing) {
  account.ask(100'000);
  enter(over_network(1, 100'000, 1));
  enter(over_network(11, 100'000, 2));
  enter(by_memory(21));
  enter(over_network(31, 100'000, 4));
  EXPECT_EQ(lost, 0U);
  EXPECT_EQ(withheld, 27U);
}

TEST_F(SequenceAccountTest, TheFirstRetainedSampleTellsWhatIsMissing) {
  account.owe(5);
  Arrival retained = over_network(8);
  retained.origin.oldest_retained = 6;
  enter(retained);
  EXPECT_EQ(lost, 2U);
  enter(over_network(10));
  EXPECT_EQ(lost, 3U);
}

TEST_F(SequenceAccountTest, WhereNothingRetainedCameWhatIsOwedIsLost) {
  account.owe(5);
  enter(by_memory(4));
  EXPECT_EQ(lost, 3U) << "the writer had no more";
  account = {};
  account.owe(5);
  enter(by_memory(100));
  EXPECT_EQ(lost, 8U);
  account = {};
  enter(by_memory(100));
  EXPECT_EQ(lost, 8U);
}

}  // namespace
}  // namespace sft::core
