// These laws follow from the projection law (every_type_law_test.cpp). The tests use a dozen types with all
// kinds of fields, random values and random masks.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "sft/detail/decode.h"
#include "sft/detail/project.h"
#include "tests/support/encoded.h"
#include "tests/support/message_types.h"
#include "tests/support/random_value.h"
#include "tests/support/reference.h"

#ifndef SFT_TEST_ROUNDS
#define SFT_TEST_ROUNDS 1000
#endif

namespace sft {
namespace {

using namespace detail;

using test::Encoded;
using test::MessageType;
using test::OwnedValue;
using ::testing::AssertionFailure;
using ::testing::AssertionResult;
using ::testing::AssertionSuccess;
namespace reference = test::reference;

class ProjectionLaw : public test::RandomTest, public ::testing::WithParamInterface<MessageType> {
 protected:
  static constexpr int rounds = SFT_TEST_ROUNDS;  // rounds per type

  /// Calls law(value, mask) with random values and closed random masks.
  template <class Law>
  void for_random_values_and_masks(Law law) {
    for (int round = 0; round < rounds; ++round) {
      const OwnedValue value = random_value();
      const FieldMask mask = random_mask();
      ASSERT_TRUE(law(value, mask)) << "in round " << round << " with the mask '"
                                    << support().format_mask(mask) << "'";
    }
  }

  OwnedValue random_value() {
    OwnedValue value = GetParam().make();
    values.fill(value.type(), value.get());
    return value;
  }
  FieldMask random_mask() { return support().closed(values.mask(support().leaves())); }

  Encoded encoded(const OwnedValue& value, const FieldMask& mask) const {
    return {value.type(), value.get(), mask};
  }

  /// Decodes into `onto`. Succeeds if the body can be decoded.
  static AssertionResult decodes(const Encoded& encoded, OwnedValue& onto) {
    const WalkStatus status = decode(encoded.state(), onto.type(), onto.get());
    return status == WalkStatus::ok ? AssertionSuccess() : AssertionFailure() << to_string(status);
  }

  const TypeSupport& support() const { return *GetParam().support; }
  const StructType& type() const { return support().type(); }

  test::RandomValues values{random};
};

std::vector<std::byte> bytes_of(const Projection& projection) {
  std::vector<std::byte> bytes;
  for (const Segment& s : projection.segments()) bytes.insert(bytes.end(), s.data, s.data + s.bytes);
  return bytes;
}

AssertionResult same_bytes(const std::vector<std::byte>& a, const std::vector<std::byte>& b) {
  const auto [at_a, at_b] = std::mismatch(a.begin(), a.end(), b.begin(), b.end());
  if (at_a == a.end() && at_b == b.end()) return AssertionSuccess();
  return AssertionFailure() << a.size() << " and " << b.size() << " bytes, different from "
                            << at_a - a.begin() << " on";
}

TEST_P(ProjectionLaw, DecodingOntoAnotherValueKeepsWhatWasNotSelected) {
  for_random_values_and_masks([this](const OwnedValue& value, const FieldMask& mask) {
    const OwnedValue before = random_value();
    OwnedValue decoded = GetParam().make();
    OwnedValue projected = GetParam().make();
    reference::project(before, support().full(), decoded);
    reference::project(before, support().full(), projected);
    reference::project(value, mask, projected);
    if (const AssertionResult ok = decodes(encoded(value, mask), decoded); !ok) return ok;
    return same_value(decoded, projected);
  });
}

TEST_P(ProjectionLaw, SkippingMembersOneByOneComesByTheEntriesOfTheIndex) {
  for_random_values_and_masks([this](const OwnedValue& value, const FieldMask& mask) -> AssertionResult {
    Encoded sample = encoded(value, mask);
    const SampleState& s = sample.state();
    if (skip(s, type(), 0, 0) != s.body_bytes) return AssertionFailure() << "it ends elsewhere";
    for (std::size_t i = 0; i < type().members.size(); ++i) {
      const std::uint32_t slot = sample.index()[slot_offset(type(), i)];
      const std::uint32_t begin = member_begin(s, type(), i, 0, 0);
      const bool is_single_struct =
          type().members[i].kind == Kind::structure && type().members[i].shape == Shape::single;
      if (is_single_struct || slot == no_offset) continue;
      if (slot < begin || slot >= begin + 8) return AssertionFailure() << "member " << i << " is elsewhere";
    }
    return AssertionSuccess();
  });
}

TEST_P(ProjectionLaw, AnIndexThatWasWalkedServesTheProjectionAsWell) {
  for_random_values_and_masks([this](const OwnedValue& value, const FieldMask& mask) -> AssertionResult {
    const Encoded full = encoded(value, support().full());
    std::vector<std::uint32_t> index(full.slots());
    SampleState received = full.state();
    received.index = index.data();
    Projection projection;
    if (build_index(received, type(), index) != WalkStatus::ok) return AssertionFailure() << "not walked";
    if (!projection.project(received, type(), mask)) return AssertionFailure() << "refused";
    return same_bytes(bytes_of(projection), encoded(value, mask).bytes());
  });
}

TEST_P(ProjectionLaw, ReservedSequencesAreEncodedAsIfFilledLater) {
  for_random_values_and_masks([this](const OwnedValue& value, const FieldMask& mask) -> AssertionResult {
    // Reserves each sequence outside of collections with its length in the value.
    OwnedValue prototype = GetParam().make();
    std::vector<Reservation> reservations;
    reference::project(value, support().full(), prototype);
    for (std::size_t i = 0; i < type().members.size(); ++i) {
      const Member& m = type().members[i];
      if (m.shape != Shape::sequence || !is_primitive(m.kind)) continue;
      reservations.push_back(
          {leaf_offset(type(), i), static_cast<std::uint32_t>(test::elements_of(m, value.get()).count)});
      test::resized(m, prototype.get(), values.up_to(3));
    }
    const Encoded expected = encoded(value, mask);
    const EncodedSize size = encoded_size(type(), prototype.get(), mask, reservations);
    if (size.status != EncodeStatus::ok) return AssertionFailure() << to_string(size.status);
    if (size.bytes != expected.state().body_bytes) return AssertionFailure() << size.bytes << " bytes";

    std::vector<std::byte> body = expected.bytes();  // already has the elements, which must not be changed
    std::vector<std::uint32_t> index(expected.slots());
    encode(type(), prototype.get(), mask, body, index, reservations);
    if (!std::equal(index.begin(), index.end(), expected.state().index))
      return AssertionFailure() << "another index";
    return same_bytes(body, expected.bytes());
  });
}

TEST_P(ProjectionLaw, AClosedMaskHasWhatWasAskedForItsLengthsAndTheKeysAndNothingElse) {
  for (int round = 0; round < rounds; ++round) {
    const FieldMask asked = values.mask(support().leaves());
    ASSERT_EQ(support().closed(asked), reference::closed(type(), asked)) << support().format_mask(asked);
    ASSERT_EQ(support().closed(support().closed(asked)), support().closed(asked))
        << support().format_mask(asked);
  }
}

TEST_P(ProjectionLaw, TheTextOfAMaskNamesThatMask) {
  for (int round = 0; round < 100; ++round) {
    const FieldMask mask = values.mask(support().leaves());
    const Result<FieldMask> parsed = support().parse_mask(support().format_mask(mask));
    ASSERT_TRUE(parsed) << parsed.error().message;
    ASSERT_EQ(*parsed, mask) << support().format_mask(mask);
  }
}

TEST_P(ProjectionLaw, LeavesAreCountedAlike) {
  EXPECT_EQ(support().leaves(), reference::leaves(type()));
  EXPECT_EQ(leaf_count(type()), reference::leaves(type()));
}

INSTANTIATE_TEST_SUITE_P(Of, ProjectionLaw,
                         ::testing::ValuesIn(test::all_types().begin(), test::all_types().end()),
                         [](const auto& type) { return type.param.short_name(); });

}  // namespace
}  // namespace sft
