// Tests which samples pass gates, with which ordinals, and with which counts. Other tests cover conditions
// alone. Here conditions are combined with a maximum rate, and with readers whose requests have just taken
// effect.
#include "core/seam/gate.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <limits>
#include <sensor_msgs/msg/BatteryState.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "core/seam/rate_budget.h"
#include "sft/detail/conditions.h"
#include "sft/type_support.h"
#include "tests/support/gate_reference.h"
#include "tests/support/random_conditions.h"
#include "tests/support/test_seed.h"

namespace sft::core {
namespace {

using sensor_msgs::msg::BatteryState;
using Condition = Selection::Condition;

constexpr std::int64_t milliseconds = 1'000'000;
// For each period in these tests, a slot begins at this time.
constexpr std::int64_t begin_ns = 1'700'000'000'000'000'000;

detail::FieldSource source(const BatteryState& battery) { return detail::FieldSource::of_message(&battery); }

/// The gate for the text of a selection. If the text has a maximum rate, it becomes the minimum period of
/// the gate.
class Stream {
 public:
  explicit Stream(std::string_view text) : selection_(type().parse_selection(text).value()) {}

  static const TypeSupport& type() { return type_support<BatteryState>(); }
  Gate& gate() { return gate_; }

  bool passes(float voltage, std::int64_t stamp_ns) {
    BatteryState battery;
    battery.voltage = voltage;
    gate_.consider(source(battery), stamp_ns);
    gate_.made(source(battery), stamp_ns);
    return gate_.passes();
  }

 private:
  Selection selection_;
  Gate gate_{static_cast<std::uint32_t>(selection_.gate().least_period.count()),
             detail::Conditions(type().type(), selection_.gate().conditions),
             selection_.without_rate().gate_hash()};
};

TEST(GateTest, NothingPassesBeforeItsFirstReaderBegins) {
  Stream stream("* @ voltage > 1");
  for (int i = 0; i < 5; ++i) EXPECT_FALSE(stream.passes(2, begin_ns + i * milliseconds));
  EXPECT_EQ(stream.gate().ordinal(), 0U);
  EXPECT_EQ(stream.gate().withheld(), 5U);
  stream.gate().reader_begins();
  EXPECT_TRUE(stream.passes(2, begin_ns + 5 * milliseconds));
  EXPECT_TRUE(stream.passes(2, begin_ns + 6 * milliseconds));
  EXPECT_EQ(stream.gate().ordinal(), 2U);
}

TEST(GateTest, AComparisonWithAConstantRefusesTheFirstSample) {
  Stream stream("* @ voltage > 1");
  stream.gate().reader_begins();
  EXPECT_FALSE(stream.passes(0, begin_ns));
  EXPECT_TRUE(stream.passes(2, begin_ns + milliseconds));
  stream.gate().reader_begins();
  EXPECT_FALSE(stream.passes(0, begin_ns + 2 * milliseconds)) << "whoever begins";
  EXPECT_EQ(stream.gate().withheld(), 2U);
  EXPECT_EQ(stream.gate().ordinal(), 1U);
}

TEST(GateTest, TheFirstSampleIsTheFirstThatComparisonsLetPass) {
  Stream stream("* @ changed(voltage) 5 and voltage > 1");
  stream.gate().reader_begins();
  EXPECT_TRUE(stream.passes(2, begin_ns));
  EXPECT_FALSE(stream.passes(3, begin_ns + milliseconds));
  stream.gate().reader_begins();
  EXPECT_FALSE(stream.passes(0, begin_ns + 2 * milliseconds));
  EXPECT_TRUE(stream.passes(3, begin_ns + 3 * milliseconds)) << "the reader that begins has had none before";
  EXPECT_FALSE(stream.passes(4, begin_ns + 4 * milliseconds));
}

TEST(GateTest, AHeartbeatBesideAComparisonLetsTheFirstSamplePassWhateverItSays) {
  Stream stream("* @ voltage > 1 or every 10 s");
  stream.gate().reader_begins();
  EXPECT_TRUE(stream.passes(0, begin_ns));
  EXPECT_FALSE(stream.passes(0, begin_ns + milliseconds));
}

TEST(GateTest, TheFirstSamplePassesAlsoIfItIsNotANumber) {
  Stream stream("* @ changed(voltage) 1");
  stream.gate().reader_begins();
  EXPECT_TRUE(stream.passes(std::numeric_limits<float>::quiet_NaN(), begin_ns));
  EXPECT_FALSE(stream.passes(std::numeric_limits<float>::quiet_NaN(), begin_ns + milliseconds));
  EXPECT_TRUE(stream.passes(0, begin_ns + 2 * milliseconds));
}

TEST(GateTest, WhenAnotherReaderBeginsTheNextSamplePassesForAllOfThem) {
  Stream stream("* @ changed(voltage) 1");
  stream.gate().reader_begins();
  EXPECT_TRUE(stream.passes(10, begin_ns));
  EXPECT_FALSE(stream.passes(10.5F, begin_ns + milliseconds));
  stream.gate().reader_begins();
  stream.gate().reader_begins();
  EXPECT_TRUE(stream.passes(10.5F, begin_ns + 2 * milliseconds));
  EXPECT_FALSE(stream.passes(11.25F, begin_ns + 3 * milliseconds)) << "it is one sample for both of them";
  EXPECT_TRUE(stream.passes(11.75F, begin_ns + 4 * milliseconds)) << "later ones are compared with it";
}

TEST(GateTest, TheFirstSamplePassesWhateverTheRateSays) {
  Stream stream("* @ voltage > 1 at most 1 Hz");
  stream.gate().reader_begins();
  EXPECT_TRUE(stream.passes(2, begin_ns));
  stream.gate().reader_begins();
  EXPECT_FALSE(stream.passes(0, begin_ns + milliseconds));
  EXPECT_TRUE(stream.passes(2, begin_ns + 2 * milliseconds));
  EXPECT_FALSE(stream.passes(2, begin_ns + 3 * milliseconds));
}

TEST(GateTest, ASampleThatDoesNotFulfilTheConditionsDoesNotSpendTheRate) {
  Stream stream("* @ voltage > 1 at most 10 Hz");
  stream.gate().reader_begins();
  EXPECT_TRUE(stream.passes(2, begin_ns));
  for (int i = 1; i < 95; ++i) EXPECT_FALSE(stream.passes(0, begin_ns + (100 + i) * milliseconds)) << i;
  EXPECT_TRUE(stream.passes(2, begin_ns + 199 * milliseconds));
}

TEST(GateTest, OfSamplesThatFulfilTheConditionsNoMorePassThanTheRatePermits) {
  Stream stream("* @ voltage > 1 at most 10 Hz");
  stream.gate().reader_begins();
  int passed = 0;
  for (int i = 0; i < 10'000; i += 7) passed += stream.passes(2, begin_ns + i * milliseconds) ? 1 : 0;
  EXPECT_GE(passed, 99);
  EXPECT_LE(passed, 102);
}

TEST(GateTest, WhatTheRateWithholdsIsNotWhatLaterSamplesAreComparedWith) {
  Stream stream("* @ changed(voltage) 1 at most 1 Hz");
  stream.gate().reader_begins();
  EXPECT_TRUE(stream.passes(10, begin_ns));
  int passed = 0;
  for (int i = 1; i < 1000; i += 100) passed += stream.passes(12, begin_ns + i * milliseconds) ? 1 : 0;
  EXPECT_LE(passed, 1);
  if (passed == 0) {
    EXPECT_TRUE(stream.passes(12, begin_ns + 2500 * milliseconds)) << "it is still a change";
  }
  EXPECT_FALSE(stream.passes(12, begin_ns + 9000 * milliseconds));
}

TEST(GateTest, FirstSamplesOfReadersDoNotRaiseTheRateInTheLongRun) {
  Stream stream("* @ voltage > 1 at most 10 Hz");
  int passed = 0;
  for (int i = 0; i < 1000; ++i) {
    if (i < 500 && i % 10 == 0) stream.gate().reader_begins();
    passed += stream.passes(2, begin_ns + i * 10 * milliseconds) ? 1 : 0;
  }
  EXPECT_GE(passed, 99);
  EXPECT_LE(passed, 102);
}

TEST(GateTest, AMessageThatIsRefusedCountsAsIfItHadNotBeenPublished) {
  Stream stream("* @ changed(voltage)");
  stream.gate().reader_begins();
  BatteryState battery;
  battery.voltage = 7;
  const auto refuse = [&] {
    stream.gate().consider(source(battery), begin_ns);
    EXPECT_TRUE(stream.gate().passes());
    stream.gate().refused();
  };
  refuse();
  EXPECT_EQ(stream.gate().ordinal(), 0U);
  EXPECT_TRUE(stream.passes(0, begin_ns)) << "this one is the first";
  refuse();
  EXPECT_TRUE(stream.passes(7, begin_ns)) << "nobody has had it";
  EXPECT_EQ(stream.gate().ordinal(), 2U);
}

TEST(GateTest, AMessageForWhichThereIsNoMemoryIsMissedAndTheNextOneIsComparedWithTheOneBefore) {
  Stream stream("* @ changed(voltage)");
  stream.gate().reader_begins();
  EXPECT_TRUE(stream.passes(1, begin_ns));
  BatteryState battery;
  battery.voltage = 2;
  stream.gate().consider(source(battery), begin_ns);  // after that, memory for this message was lacking, so
                                                      // neither made() nor refused() is called
  EXPECT_EQ(stream.gate().ordinal(), 2U) << "its readers see that one is missing";
  EXPECT_TRUE(stream.passes(2, begin_ns));
  EXPECT_FALSE(stream.passes(2, begin_ns));
}

TEST(GateTest, AFirstMessageForWhichThereIsNoMemoryIsMissedAndTheNextOneIsTheFirst) {
  Stream stream("* @ changed(voltage)");
  stream.gate().reader_begins();
  EXPECT_TRUE(stream.passes(1, begin_ns));
  stream.gate().reader_begins();
  BatteryState battery;
  battery.voltage = 1;
  stream.gate().consider(source(battery), begin_ns);  // after that, memory for this message was lacking, so
                                                      // neither made() nor refused() is called
  EXPECT_TRUE(stream.gate().passes());
  EXPECT_TRUE(stream.passes(1, begin_ns));
  EXPECT_FALSE(stream.passes(1, begin_ns));
}

TEST(GateTest, EveryThirdCountsTheFirstSamplesOfReadersToo) {
  Stream stream("* @ every 3rd");
  stream.gate().reader_begins();
  for (int i = 0; i < 30; ++i) {
    if (i == 10) stream.gate().reader_begins();
    EXPECT_EQ(stream.passes(0, begin_ns + i * milliseconds), i % 3 == 0 || i == 10) << i;
  }
}

TEST(GateTest, APeriodBeginsWithTheFirstSampleOfAReader) {
  Stream stream("* @ every 10 s");
  stream.gate().reader_begins();
  EXPECT_TRUE(stream.passes(0, begin_ns));
  stream.gate().reader_begins();
  EXPECT_TRUE(stream.passes(0, begin_ns + 5000 * milliseconds));
  EXPECT_FALSE(stream.passes(0, begin_ns + 10'000 * milliseconds));
  EXPECT_TRUE(stream.passes(0, begin_ns + 15'000 * milliseconds));
}

TEST(GateTest, ARateAloneNeedsNoReaderThatBegins) {
  Gate gate(100'000);
  EXPECT_EQ(gate.id(), 0U);
  const auto passes = [&](std::int64_t stamp_ns) {
    gate.consider(detail::FieldSource::of_nothing(), stamp_ns);
    return gate.passes();
  };
  EXPECT_TRUE(passes(begin_ns));
  EXPECT_FALSE(passes(begin_ns + 50 * milliseconds));
  EXPECT_TRUE(passes(begin_ns + 100 * milliseconds));
  EXPECT_EQ(gate.ordinal(), 2U);
  EXPECT_EQ(gate.withheld(), 1U);
}

TEST(GateTest, IsNamedByItsConditionsAndItsRate) {
  Stream one("* @ voltage > 1"), same("* @ voltage > 1.0"), other("* @ voltage > 2");
  Stream slow("* @ voltage > 1 at most 2 Hz");
  EXPECT_NE(one.gate().id(), 0U);
  EXPECT_EQ(one.gate().id(), same.gate().id());
  EXPECT_NE(one.gate().id(), other.gate().id());
  EXPECT_NE(one.gate().id(), slow.gate().id());
  EXPECT_EQ(slow.gate().min_period_us(), 500'000U);
}

class GateLaw : public test::RandomTest {
 protected:
  /// A reference implementation: returns true if a sample should pass. The rate applies only to samples for
  /// which the conditions hold. The first sample of a reader is subtracted from the budget, even if the
  /// budget is used up.
  static bool permits(bool holds, bool begins, RateBudget& budget, std::int64_t stamp_ns) {
    if (!holds) return false;
    if (!begins) return budget.take(stamp_ns);
    budget.spend(stamp_ns);
    return true;
  }
  bool one_in(std::uint64_t n) { return random() % n == 0; }
};

TEST_F(GateLaw, LetsThoseSamplesPassThatAPlainReadingNames) {
  const TypeSupport& type = type_support<BatteryState>();
  for (std::uint64_t round = 0; round < test::test_rounds(500); ++round) {
    test::RandomConditions any(random, type.type());
    const std::vector<Condition> said = any.conditions();
    const auto period_us =
        static_cast<std::uint32_t>(one_in(3) ? 0 : 1 + random() % (one_in(2) ? 1000 : 1'000'000));
    const Selection selection =
        Selection::make(type.full(), {},
                        {.conditions = said, .least_period = std::chrono::microseconds(period_us)})
            .value();
    SCOPED_TRACE("in round " + std::to_string(round) + ": " + type.format_selection(selection));
    Gate gate(period_us, detail::Conditions(type.type(), selection.gate().conditions),
              selection.without_rate().gate_hash());
    test::GateReference reference(said);
    RateBudget budget(period_us, 1);
    BatteryState battery;
    std::int64_t stamp_ns = begin_ns;
    std::uint32_t passed = 0;
    for (std::uint32_t i = 0; i < 40; ++i) {
      if (i == 0 || one_in(15)) {
        gate.reader_begins();
        reference.begin();
      }
      const bool begins = reference.begins();
      const test::FieldValues values = test::values_of(any.fields(), &battery);
      const bool holds = reference.holds(values, stamp_ns);
      gate.consider(source(battery), stamp_ns);
      gate.made(source(battery), stamp_ns);
      const bool passes = permits(holds, begins, budget, stamp_ns);
      if (reference.was_close()) break;  // the later results may depend on rounding
      ASSERT_EQ(gate.passes(), passes) << "sample " << i;
      passed += passes ? 1 : 0;
      ASSERT_EQ(gate.ordinal(), passed);
      ASSERT_EQ(gate.passed(), passed);
      ASSERT_EQ(gate.withheld(), i + 1 - passed);
      if (passes) reference.passed(values, stamp_ns);
      any.change(&battery);
      stamp_ns = any.stamp_behind(stamp_ns);
    }
  }
}

}  // namespace
}  // namespace sft::core
