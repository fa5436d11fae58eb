// Conditions on fields that are not single values are refused. If a sample has false lengths, only bytes of
// the sample are read.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <sensor_msgs/msg/BatteryState.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <string>
#include <string_view>
#include <torture.hpp>
#include <vector>

#include "sft/detail/conditions.h"
#include "tests/support/asked.h"
#include "tests/support/gate_reference.h"
#include "tests/support/random_value.h"
#include "tests/support/single_valued_types.h"

#ifndef SFT_TEST_ROUNDS
#define SFT_TEST_ROUNDS 1000
#endif

namespace sft {
namespace {

using Condition = Selection::Condition;
using sensor_msgs::msg::BatteryState;
using sensor_msgs::msg::PointCloud2;
using test::ExactSample;
using test::MessageType;
using test::OwnedValue;

constexpr std::int64_t any_ns = 1'700'000'000'123'456'789;

/// Returns the number of the first leaf that the path names.
template <class T>
std::uint32_t leaf(std::string_view path) {
  return static_cast<std::uint32_t>(*type_support<T>().find(path).value().begin());
}
std::vector<Condition> conditions_in(const TypeSupport& type, std::string_view text) {
  return type.parse_selection(text).value().gate().conditions;
}
template <class T>
bool accepts_change_of(std::uint32_t leaf) {
  const Condition condition{.kind = Condition::Kind::changed, .leaves = {leaf}};
  return static_cast<bool>(detail::Conditions::check(type_support<T>().type(), {&condition, 1}));
}

TEST(ConditionsCheck, RefusesFieldsInSequencesAndArrays) {
  EXPECT_TRUE(accepts_change_of<BatteryState>(leaf<BatteryState>("voltage")));
  EXPECT_FALSE(accepts_change_of<BatteryState>(leaf<BatteryState>("cell_voltage")));
  EXPECT_FALSE(accepts_change_of<PointCloud2>(leaf<PointCloud2>("fields[].offset")));
  EXPECT_FALSE(accepts_change_of<PointCloud2>(leaf<PointCloud2>("fields.size")));
  EXPECT_FALSE(accepts_change_of<torture::Arrays>(leaf<torture::Arrays>("one")));
  EXPECT_FALSE(accepts_change_of<torture::Arrays>(leaf<torture::Arrays>("points[].x")));
  EXPECT_FALSE(type_support<PointCloud2>().parse_selection("* @ changed(header)"));
}

TEST(ConditionsCheck, RefusesTextsInComparisons) {
  const StructType& type = type_support<BatteryState>().type();
  const Condition compare{.kind = Condition::Kind::compare, .leaves = {leaf<BatteryState>("location")}};
  EXPECT_FALSE(detail::Conditions::check(type, {&compare, 1}));
  EXPECT_TRUE(accepts_change_of<BatteryState>(leaf<BatteryState>("location")));
}

TEST(ConditionsCheck, RefusesLeavesThatTheTypeLacks) {
  const auto leaves = static_cast<std::uint32_t>(type_support<BatteryState>().leaves());
  EXPECT_TRUE(accepts_change_of<BatteryState>(leaves - 1)) << "the serial number";
  for (const std::uint32_t beyond : {leaves, leaves + 1, UINT32_MAX})
    EXPECT_FALSE(accepts_change_of<BatteryState>(beyond));
}

TEST(ConditionsCheck, LooksAtEachOfSeveralConditions) {
  const TypeSupport& type = type_support<BatteryState>();
  std::vector<Condition> conditions =
      conditions_in(type, "* @ voltage > 1 and (every 2nd or changed(voltage))");
  EXPECT_TRUE(detail::Conditions::check(type.type(), conditions));
  for (Condition& condition : conditions) {
    if (condition.leaves.empty()) continue;
    const auto honest = condition.leaves;
    condition.leaves.push_back(leaf<BatteryState>("cell_voltage"));
    if (condition.kind == Condition::Kind::compare) condition.leaves = {leaf<BatteryState>("cell_voltage")};
    EXPECT_FALSE(detail::Conditions::check(type.type(), conditions));
    condition.leaves = honest;
  }
}

TEST(ConditionsCheck, AcceptsJustTheSingleValuesOfEachType) {
  for (const MessageType& type : test::types_with_single_values()) {
    const auto fields = test::single_fields(type.type());
    for (std::uint32_t leaf = 0; leaf < type.support->leaves() + 3; ++leaf) {
      const auto field = std::ranges::find(fields, leaf, &test::SingleField::leaf);
      const bool is_single = field != fields.end();
      const bool is_text = is_single && field->member->kind == detail::Kind::string;
      const auto is_accepted = [&](const Condition& condition) {
        return static_cast<bool>(detail::Conditions::check(type.type(), {&condition, 1}));
      };
      SCOPED_TRACE(std::string(type.support->name()) + ", leaf " + std::to_string(leaf));
      EXPECT_EQ(is_accepted({.kind = Condition::Kind::changed, .leaves = {leaf}}), is_single);
      EXPECT_EQ(is_accepted({.kind = Condition::Kind::compare, .leaves = {leaf}}), is_single && !is_text);
      if (leaf > fields[0].leaf) {
        EXPECT_EQ(is_accepted({.kind = Condition::Kind::changed, .leaves = {fields[0].leaf, leaf}}),
                  is_single);
      }
    }
  }
}

class HostileSample : public test::RandomTest {
 protected:
  static int rounds() { return static_cast<int>(test::test_rounds(SFT_TEST_ROUNDS)); }
  bool one_in(std::uint64_t n) { return random() % n == 0; }

  /// Evaluates the conditions and ignores the results. A sanitizer checks that only bytes of the sample are
  /// read.
  static void ask(const StructType& type, const std::vector<Condition>& conditions,
                  const detail::SampleState& state) {
    detail::Conditions asked(type, conditions);
    for (int i = 0; i < 3; ++i) {
      const auto sample = detail::FieldSource::of_sample(state);
      asked.hold(sample, any_ns + i);
      asked.passed(sample, any_ns + i);
    }
  }
  /// Returns one condition for each field that is a single value.
  static std::vector<Condition> on_all_fields(const StructType& type) {
    std::vector<Condition> conditions;
    for (const test::SingleField& field : test::single_fields(type)) {
      if (conditions.size() + 1 == Selection::conditions_max) break;
      conditions.push_back({.kind = Condition::Kind::changed, .leaves = {field.leaf}});
      if (field.member->kind != detail::Kind::string && field.leaf % 2 == 0)
        conditions.back().kind = Condition::Kind::compare;
    }
    const auto children = static_cast<std::uint32_t>(conditions.size());
    if (children > 1)
      conditions.insert(conditions.begin(), {.kind = Condition::Kind::any_of, .children = children});
    return conditions;
  }

  const std::vector<MessageType> types = test::types_with_single_values();
  test::RandomValues values{random};
};

TEST_F(HostileSample, ThatIsCutOffAnywhereIsReadWithinItsBytes) {
  for (const MessageType& type : types) {
    OwnedValue message = type.make();
    values.fill(type.type(), message.get());
    const ExactSample honest(type.type(), message.get(), type.support->full());
    const std::vector<Condition> conditions = on_all_fields(type.type());
    const std::uint32_t bytes = honest.state().body_bytes;
    for (std::uint32_t kept = 0; kept < bytes; kept += 1 + kept / 32) {
      const std::vector<std::byte> body(honest.state().body, honest.state().body + kept);
      detail::SampleState state = honest.state();
      state.body = body.data();
      state.body_bytes = kept;
      ask(type.type(), conditions, state);
    }
  }
}

TEST_F(HostileSample, OfAnyBytesIsReadWithinThem) {
  for (int round = 0; round < rounds(); ++round) {
    const MessageType& type = types[random() % types.size()];
    OwnedValue message = type.make();
    values.fill(type.type(), message.get());
    const ExactSample honest(type.type(), message.get(), type.support->full());
    std::vector<std::byte> body(honest.state().body, honest.state().body + honest.state().body_bytes);
    for (std::byte& byte : body)
      if (one_in(4)) byte = one_in(2) ? std::byte{0xff} : static_cast<std::byte>(random());
    detail::SampleState state = honest.state();
    state.body = body.data();
    ask(type.type(), on_all_fields(type.type()), state);
  }
}

TEST_F(HostileSample, WithAnIndexThatLiesIsReadWithinItsBytes) {
  for (int round = 0; round < rounds(); ++round) {
    const MessageType& type = types[random() % types.size()];
    std::vector<std::byte> body(random() % 100);
    for (std::byte& byte : body) byte = static_cast<std::byte>(one_in(3) ? 0 : random());
    std::vector<std::uint32_t> index(detail::slot_count(type.type()));
    for (std::uint32_t& offset : index) {
      offset = static_cast<std::uint32_t>(random() % (body.size() + 9));
      if (one_in(4)) offset = detail::no_offset - static_cast<std::uint32_t>(random() % 9);
    }
    const FieldMask mask = one_in(2) ? type.support->full() : type.support->none();
    const detail::SampleState state{.body = body.data(),
                                    .body_bytes = static_cast<std::uint32_t>(body.size()),
                                    .index = index.data(),
                                    .mask = &mask};
    ask(type.type(), on_all_fields(type.type()), state);
  }
}

}  // namespace
}  // namespace sft
