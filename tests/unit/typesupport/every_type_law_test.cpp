// The projection law, for all types that the tests have. The fields in a mask have the same values in all
// ways of getting them. The sample is encoded under the mask, or projected from a larger sample. The type is
// compiled, or parsed from its description. The sample is decoded into the owned struct, or read through a
// dynamic view. The plainest implementation (reference.h) gives the same values.
#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>
#include <set>

#include "sft/detail/decode.h"
#include "sft/detail/project.h"
#include "sft/detail/type_description.h"
#include "sft/dynamic_type.h"
#include "sft/dynamic_view.h"
#include "tests/support/encoded.h"
#include "tests/support/message_types.h"
#include "tests/support/random_value.h"
#include "tests/support/reference.h"
#include "tests/support/value_tree.h"

#ifndef SFT_TEST_TRIPLES
#define SFT_TEST_TRIPLES 100000
#endif

namespace sft {
namespace {

using namespace detail;

using test::Encoded;
using test::MessageType;
using test::OwnedValue;
namespace reference = test::reference;

// The number of triples of a type, a value and a mask.
constexpr std::size_t triples_wanted = SFT_TEST_TRIPLES;
constexpr std::size_t masks_per_value = 4;

std::vector<std::byte> bytes_of(const Projection& projection) {
  std::vector<std::byte> bytes;
  bytes.reserve(projection.bytes());
  for (const Segment& s : projection.segments()) bytes.insert(bytes.end(), s.data, s.data + s.bytes);
  return bytes;
}

/// Returns the mask of the lengths of all sequences of structs.
FieldMask lengths_of(const TypeSupport& type) {
  FieldMask lengths(type.leaves());
  for (const std::size_t leaf : type.full()) {
    FieldMask one(type.leaves());
    one.insert(leaf);
    lengths |= type.closed(one) - one - type.closed(FieldMask(type.leaves()));
  }
  return lengths;
}

class EveryTypeLaw : public test::RandomTest, public ::testing::WithParamInterface<MessageType> {
 protected:
  static void TearDownTestSuite() {
    std::cout << "checked " << checked_in_all << " triples of a type, a value and a mask\n";
    RecordProperty("triples", std::to_string(checked_in_all));
  }

  OwnedValue random_value() {
    OwnedValue value = GetParam().make();
    values.fill(value.type(), value.get());
    return value;
  }

  /// Returns a mask of a random kind: of some density, a single leaf, all leaves but one, lengths only, none,
  /// or all. The mask is not closed.
  FieldMask random_mask() {
    const std::size_t leaves = compiled.leaves();
    switch (random() % 8) {
      case 0:
        return values.mask(leaves) & lengths;
      case 1: {
        FieldMask mask = compiled.full();
        mask.erase(random() % leaves);
        return mask;
      }
      default:
        return values.mask(leaves);
    }
  }

  void law(const OwnedValue& value, const Encoded& full, const FieldMask& asked) {
    const FieldMask mask = reference::closed(type, asked);
    ASSERT_EQ(compiled.closed(asked), mask);
    ASSERT_EQ(parsed.support().closed(asked), mask);

    const Encoded sample(type, value.get(), mask);
    ASSERT_EQ(sample.bytes(), reference::cdr(value, mask));
    projections_are_the_sample(full, sample);
    projections_are_the_sample(Encoded(type, value.get(), mask | compiled.closed(random_mask())), sample);

    if (random() % 4 == 0) postponed_copies_are_made_later(value, sample);

    OwnedValue expected = GetParam().make();
    reference::project(value, mask, expected);
    walks_find_the_index(sample);
    decodes_to(expected, sample);
    shows(expected, sample);
    shows_what_is_declared(expected, full, mask);
  }

  /// Projects `source` by a plan of the compiled type and by one of the parsed type. Expects both results to
  /// equal `sample`.
  void projections_are_the_sample(const Encoded& source, const Encoded& sample) {
    for (const StructType* of : {&type, &parsed.type()}) {
      ASSERT_TRUE(projection.project(source.state(), ProjectionPlan(*of, *sample.state().mask)));
      ASSERT_EQ(bytes_of(projection), sample.bytes())
          << "from '" << compiled.format_mask(*source.state().mask) << "'";
    }
  }

  /// Encodes with postponed copies. Expects that the bytes are found in the value until the copies are made.
  void postponed_copies_are_made_later(const OwnedValue& value, const Encoded& sample) {
    std::vector<std::uint64_t> memory(sample.bytes().size() / 8 + 1, 0x5a5a5a5a5a5a5a5a);
    const std::span body(reinterpret_cast<std::byte*>(memory.data()), sample.bytes().size());
    std::vector<std::uint32_t> index(sample.slots());
    PostponedCopies copies(1 + random() % 16);
    encode(type, value.get(), *sample.state().mask, body, index, {}, &copies);
    for (;; copies.make(1 + random() % 64)) {
      const Segment whole{body.data(), body.size()};
      std::vector<Segment> located;
      copies.locate({&whole, 1}, located);
      std::vector<std::byte> bytes;
      for (const Segment& s : located) bytes.insert(bytes.end(), s.data, s.data + s.bytes);
      ASSERT_EQ(bytes, sample.bytes());
      if (copies.empty()) break;
    }
    ASSERT_TRUE(std::ranges::equal(body, sample.bytes()));
  }

  void walks_find_the_index(const Encoded& sample) {
    for (const StructType* of : {&type, &parsed.type()}) {
      std::vector<std::uint32_t> index(sample.slots(), 0x5a5a5a5a);
      std::uint32_t end = 0;
      ASSERT_EQ(build_index(sample.state(), *of, index, &end), WalkStatus::ok);
      ASSERT_EQ(end, sample.state().body_bytes);
      ASSERT_TRUE(std::equal(index.begin(), index.end(), sample.state().index));
      ASSERT_EQ(skip(sample.state(), *of, 0, 0), end);
    }
  }

  void decodes_to(const OwnedValue& expected, const Encoded& sample) {
    OwnedValue decoded = GetParam().make();
    ASSERT_EQ(decode(sample.state(), type, decoded.get()), WalkStatus::ok);
    ASSERT_TRUE(same_value(decoded, expected));
  }

  /// Expects a view to show the members that are present, with their values, and no other members.
  void shows(const OwnedValue& expected, const Encoded& sample) {
    SampleState state = sample.state();
    if (random() % 2 == 0) state.index = nullptr;
    ASSERT_EQ(test::value_tree(DynamicView(state, parsed.type())), test::value_tree(expected, *state.mask));
    ASSERT_FALSE(state.is_malformed());
  }

  /// Expects that a reader of a full sample sees exactly the members that the reader declared.
  void shows_what_is_declared(const OwnedValue& expected, const Encoded& full, const FieldMask& mask) {
    SampleState state = full.state();
    if (random() % 2 == 0) state.index = nullptr;
    ASSERT_EQ(test::value_tree(DynamicView(state, parsed.type(), mask)), test::value_tree(expected, mask));
  }

  // The triples of this process, which may run one of several shards.
  static inline std::size_t checked_in_all = 0;

  const TypeSupport& compiled = *GetParam().support;
  const StructType& type = compiled.type();
  const DynamicType parsed = DynamicType::parse(describe(type)).value();
  const FieldMask lengths = lengths_of(compiled);
  Projection projection;  // used in all rounds, so that a remainder of a previous sample would be noticed
  test::RandomValues values{random};
};

TEST_P(EveryTypeLaw, HoldsByAllWays) {
  const std::size_t triples = test::test_rounds(triples_wanted) / test::every_type().size() + 1;
  std::size_t checked = 0;
  while (checked < triples) {
    const OwnedValue value = random_value();
    const Encoded full(type, value.get(), compiled.full());
    for (std::size_t i = 0; i < masks_per_value; ++i, ++checked) {
      const FieldMask mask = random_mask();
      ASSERT_NO_FATAL_FAILURE(law(value, full, mask))
          << "triple " << checked << ", mask '" << compiled.format_mask(mask) << "'";
    }
  }
  checked_in_all += checked;
}

TEST(EveryType, IsThereOnce) {
  std::set<std::string_view> names;
  for (const MessageType& type : test::every_type())
    EXPECT_TRUE(names.insert(type.support->name()).second) << type.support->name();
  EXPECT_GE(names.size(),
            200U);  // 118 of the common packages, 11 of ROS 2's tests, and some difficult ones
}

INSTANTIATE_TEST_SUITE_P(Of, EveryTypeLaw, ::testing::ValuesIn(test::every_type()),
                         [](const auto& type) { return type.param.test_name(); });

}  // namespace
}  // namespace sft
