// Random conditions over random streams hold for exactly the samples for which a second, plain implementation
// of the specification says so. The fields are read from messages and from samples.
#include <gtest/gtest.h>

#include <cstdint>
#include <sstream>
#include <string>
#include <variant>
#include <vector>

#include "sft/detail/conditions.h"
#include "tests/support/asked.h"
#include "tests/support/gate_reference.h"
#include "tests/support/random_conditions.h"
#include "tests/support/random_value.h"
#include "tests/support/single_valued_types.h"

#ifndef SFT_TEST_ROUNDS
#define SFT_TEST_ROUNDS 1000
#endif

namespace sft {
namespace {

using Condition = Selection::Condition;
using test::Asked;
using test::FieldValues;
using test::MessageType;
using test::OwnedValue;
using test::RandomConditions;

constexpr std::int64_t begin_ns = 1'700'000'000'123'456'789;

/// Returns the values of the fields that the conditions use, for messages of failures.
std::string described(const std::vector<Condition>& conditions, const FieldValues& values) {
  FieldMask leaves(conditions.empty() ? 1 : 1000);
  std::ostringstream text;
  text.precision(17);
  for (const Condition& condition : conditions)
    for (const std::uint32_t leaf : condition.leaves) leaves.insert(leaf);
  for (const std::size_t leaf : leaves) {
    text << " leaf " << leaf << ": ";
    std::visit([&](const auto& value) { text << value; }, values.at(static_cast<std::uint32_t>(leaf)));
  }
  return text.str();
}

class ConditionsLaw : public test::RandomTest {
 protected:
  static int rounds() { return static_cast<int>(test::test_rounds(SFT_TEST_ROUNDS)); }
  bool one_in(std::uint64_t n) { return random() % n == 0; }

  /// Returns the mask of all fields, or of the fields that the conditions use and random other fields.
  FieldMask mask_for(const TypeSupport& type, const std::vector<Condition>& conditions) {
    if (one_in(2)) return type.full();
    FieldMask mask = values.mask(type.leaves());
    for (const Condition& condition : conditions)
      for (const std::uint32_t leaf : condition.leaves) mask.insert(leaf);
    return type.closed(mask);
  }

  /// Checks the conditions on each sample of a stream. Now and then a new reader begins. Some samples do not
  /// pass although the conditions hold, as under a rate limit. Some samples pass although the conditions do
  /// not hold.
  void follow(const MessageType& type, RandomConditions& any, const std::vector<Condition>& said,
              Asked& asked) {
    constexpr int samples = 30;
    test::GateReference reference(said);
    OwnedValue message = type.make();
    values.fill(type.type(), message.get());
    const FieldMask mask = mask_for(*type.support, said);
    std::int64_t stamp_ns = begin_ns;
    std::string former;
    for (int i = 0; i < samples; ++i) {
      if (one_in(10)) {
        reference.begin();
        asked.begin();
      }
      const FieldValues now = test::values_of(any.fields(), message.get());
      const std::string sample = std::to_string(stamp_ns - begin_ns) + " ns" + described(said, now);
      bool expected = reference.holds(now, stamp_ns);
      const bool holds = asked.holds(message.get(), stamp_ns, mask);
      // If the result may depend on rounding, either result is accepted here. ConditionsTest checks results
      // that are known in spite of rounding.
      if (reference.was_close()) expected = holds;
      ASSERT_EQ(holds, expected) << "for sample " << i << " at " << sample << "\nbehind " << former;
      ++(holds ? held : not_held);
      if (i == 0 || (expected ? !one_in(4) : one_in(20))) {
        former = sample;
        reference.passed(now, stamp_ns);
        asked.passed(message.get(), stamp_ns, mask);
      }
      any.change(message.get());
      stamp_ns = any.stamp_behind(stamp_ns);
    }
  }

  const std::vector<MessageType> types = test::types_with_single_values();
  test::RandomValues values{random};
  int held = 0;
  int not_held = 0;
};

TEST_F(ConditionsLaw, HoldForTheSamplesThatAPlainReadingNamesIfTheyAreMade) {
  for (int round = 0; round < rounds(); ++round) {
    const MessageType& type = types[random() % types.size()];
    RandomConditions any(random, type.type());
    const std::vector<Condition> said = any.conditions();
    const Result<Selection> selection =
        Selection::make(type.support->full(), {}, {.conditions = said, .least_period = {}});
    ASSERT_TRUE(selection) << selection.error().message;
    SCOPED_TRACE(std::string(type.support->name()) + " in round " + std::to_string(round) + ": " +
                 type.support->format_selection(*selection));
    Asked asked(type.type(), selection->gate().conditions);
    follow(type, any, said, asked);
    if (HasFailure()) return;
  }
  EXPECT_GT(held, not_held / 20) << "else the conditions are dull";
  EXPECT_GT(not_held, held / 20);
}

TEST_F(ConditionsLaw, HoldForTheSamplesThatAPlainReadingNamesIfTheyAreWritten) {
  for (int round = 0; round < rounds(); ++round) {
    const MessageType& type = types[random() % types.size()];
    RandomConditions any(random, type.type());
    const std::vector<Condition> said = any.conditions();
    const std::string text = "* @ " + any.text(*type.support, said);
    SCOPED_TRACE(std::string(type.support->name()) + " in round " + std::to_string(round) + ": " + text);
    const Result<Selection> selection = type.support->parse_selection(text);
    ASSERT_TRUE(selection) << selection.error().message;
    const Selection made =
        Selection::make(type.support->full(), {}, {.conditions = said, .least_period = {}}).value();
    EXPECT_TRUE(*selection == made) << type.support->format_selection(made) << "\n"
                                    << type.support->format_selection(*selection);
    Asked asked(type.type(), selection->gate().conditions);
    follow(type, any, said, asked);
    if (HasFailure()) return;
  }
}

}  // namespace
}  // namespace sft
