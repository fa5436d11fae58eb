// A program that has only the description of a type reads fields by name, and prints them. These tests use a
// dozen types with all kinds of fields, random values and random masks. every_type_law_test.cpp shows that
// such a program reads and projects the same as a program that was compiled with the type.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "sft/detail/decode.h"
#include "sft/detail/type_description.h"
#include "sft/dynamic_type.h"
#include "sft/dynamic_view.h"
#include "sft/json.h"
#include "sft/yaml.h"
#include "tests/support/encoded.h"
#include "tests/support/message_types.h"
#include "tests/support/random_value.h"
#include "tests/support/tame_value.h"
#include "tests/support/value_tree.h"

#ifndef SFT_TEST_ROUNDS
#define SFT_TEST_ROUNDS 350
#endif

namespace sft {
namespace {

using namespace detail;

using test::Encoded;
using test::MessageType;
using test::OwnedValue;
using test::value_tree;
using test::value_tree_by_name;

class DynamicLaw : public test::RandomTest, public ::testing::WithParamInterface<MessageType> {
 protected:
  static constexpr int rounds = SFT_TEST_ROUNDS;

  /// Calls law(value, mask) with random values and closed random masks.
  template <class Law>
  void for_random_values_and_masks(Law law) {
    for (int round = 0; round < rounds; ++round) {
      OwnedValue value = GetParam().make();
      values.fill(value.type(), value.get());
      const FieldMask mask = compiled.closed(values.mask(compiled.leaves()));
      SCOPED_TRACE("round " + std::to_string(round) + ", mask '" + compiled.format_mask(mask) + "'");
      law(value, mask);
      if (HasFatalFailure()) return;
    }
  }

  const TypeSupport& compiled = *GetParam().support;
  const DynamicType parsed = DynamicType::parse(describe(compiled.type())).value();
  test::RandomValues values{random};
};

TEST_P(DynamicLaw, NamesAndNumbersLeadToTheSameValuesAsIteration) {
  for (int round = 0; round < 20; ++round) {
    OwnedValue value = GetParam().make();
    values.fill(value.type(), value.get());
    const Encoded sample(value.type(), value.get(), compiled.closed(values.mask(compiled.leaves())));
    const DynamicView view(sample.state(), parsed.type());
    ASSERT_EQ(value_tree_by_name(view), value_tree(view));
  }
}

TEST_P(DynamicLaw, TextsHaveNoMoreElementsThanTheLimit) {
  for_random_values_and_masks([&](const OwnedValue& value, const FieldMask& mask) {
    const Encoded sample(value.type(), value.get(), mask);
    const DynamicView view(sample.state(), parsed.type());
    const auto yaml = to_yaml(view, {.elements_max = 2, .text_bytes_max = 10});
    ASSERT_TRUE(yaml) << yaml.error().message;
    // The message has three levels of at most two elements. Names and numbers have at most some 40 bytes.
    ASSERT_LT(yaml->size(), 2 * 2 * 2 * 80 * compiled.leaves() + 100);
    const auto json = to_json(view, {.elements_max = 2});
    ASSERT_TRUE(json) << json.error().message;
    ASSERT_TRUE(nlohmann::json::accept(*json));
  });
}

// ---- JSON, written and read back ----

class FromJson {
 public:
  static void read(const nlohmann::json& json, const StructType& type, void* object) {
    for (const Member& m : type.members) {
      const std::string name(m.name);
      if (json.contains(name + ".size")) test::resized(m, object, json.at(name + ".size"));
      if (json.contains(name)) member(json.at(name), m, object);
    }
  }

 private:
  static void member(const nlohmann::json& json, const Member& m, void* object) {
    if (m.shape == Shape::single) return element(json, m, test::resized(m, object, 1));
    std::byte* first = test::resized(m, object, json.size());
    for (std::size_t i = 0; i < json.size(); ++i) element(json[i], m, first + i * m.stride);
  }

  static void element(const nlohmann::json& json, const Member& m, std::byte* at) {
    if (m.kind == Kind::structure) {
      read(json, *m.type, at);
    } else if (m.kind == Kind::string) {
      *reinterpret_cast<std::string*>(at) = json.get<std::string>();
    } else if (m.kind == Kind::character) {
      *at = static_cast<std::byte>(json.get<std::string>().at(0));
    } else if (m.kind == Kind::float32) {
      const auto value = static_cast<float>(number(json));
      std::memcpy(at, &value, sizeof value);
    } else if (m.kind == Kind::float64) {
      const double value = number(json);
      std::memcpy(at, &value, sizeof value);
    } else {
      integer(json, m, at);
    }
  }

  static double number(const nlohmann::json& json) {
    if (json == "NaN") return NAN;
    if (json == "Infinity") return INFINITY;
    return json == "-Infinity" ? -INFINITY : json.get<double>();
  }

  static void integer(const nlohmann::json& json, const Member& m, std::byte* at) {
    std::uint64_t bits = 0;
    if (json.is_boolean()) {
      bits = json.get<bool>() ? 1 : 0;
    } else if (json.is_string()) {
      for (const Enumerator& e : m.enumeration->enumerators) bits = json == e.name ? e.value : bits;
    } else {
      bits = json.is_number_unsigned() ? json.get<std::uint64_t>()
                                       : static_cast<std::uint64_t>(json.get<std::int64_t>());
    }
    std::memcpy(at, &bits, size_of(m.kind));
  }
};

TEST_P(DynamicLaw, JsonHasTheWholeValueOfEveryFieldThatIsThere) {
  for_random_values_and_masks([&](OwnedValue value, const FieldMask& mask) {
    test::tame(value.type(), value.get());
    const Encoded sample(value.type(), value.get(), mask);
    const auto json = to_json(DynamicView(sample.state(), parsed.type()), {.bytes_as_base64 = false});
    ASSERT_TRUE(json) << json.error().message;
    OwnedValue back = GetParam().make();
    FromJson::read(nlohmann::json::parse(*json), back.type(), back.get());
    OwnedValue expected = GetParam().make();
    ASSERT_EQ(decode(sample.state(), expected.type(), expected.get()), WalkStatus::ok);
    ASSERT_TRUE(same_value(back, expected)) << *json;
  });
}

INSTANTIATE_TEST_SUITE_P(Of, DynamicLaw,
                         ::testing::ValuesIn(test::all_types().begin(), test::all_types().end()),
                         [](const auto& type) { return type.param.short_name(); });

}  // namespace
}  // namespace sft
