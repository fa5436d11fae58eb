// The part of a message that a projection takes.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

#include "sft/detail/decode.h"
#include "sft/detail/project.h"
#include "sft/detail/walk.h"
#include "sft/type_support.h"
#include "tests/support/encoded.h"
#include "tests/support/owned_value.h"

namespace sft::test {

/// Returns the bytes of a projection, in memory of exactly their size.
inline std::vector<std::byte> gathered(const detail::Projection& projection) {
  std::vector<std::byte> bytes;
  bytes.reserve(projection.bytes());
  for (const detail::Segment& s : projection.segments()) bytes.insert(bytes.end(), s.data, s.data + s.bytes);
  return bytes;
}

/// Decodes a message with the fields in `mask`. The other fields are those of `onto`. The test fails if the
/// bytes are no such message, or if more bytes follow it.
template <class T>
T decoded_from(const std::vector<std::byte>& bytes, const FieldMask& mask, T onto = {}) {
  const StructType& type = detail::TypeTable<T>::type;
  std::vector<std::uint32_t> index(detail::slot_count(type));
  const auto size = static_cast<std::uint32_t>(bytes.size());
  const detail::SampleState state{
      .body = bytes.data(), .body_bytes = size, .index = index.data(), .mask = &mask};
  std::uint32_t end = 0;
  EXPECT_EQ(detail::build_index(state, type, index, &end), detail::WalkStatus::ok);
  EXPECT_EQ(end, size);
  EXPECT_EQ(detail::decode(state, type, &onto), detail::WalkStatus::ok);
  return onto;
}

/// Returns a selection of the whole message. The fields that the text names are reduced to the parts that the
/// text names.
template <class T>
Selection all_with(std::string_view text) {
  const TypeSupport& type = type_support<T>();
  const Selection parsed = type.parse_selection(text).value();
  const auto parts = parsed.parts();
  return Selection::make(type.full(), {parts.begin(), parts.end()}, {}).value();
}

/// The projection of one message by one selection. The encoded message fills its memory exactly, so that a
/// sanitizer notices each read beyond the message.
template <class T>
class Cut {
 public:
  Cut(const T& message, const Selection& selection)
      : Cut(message, selection, FieldMask::full(detail::leaf_count_of<T>)) {}

  /// Projects a sample that has only the fields in `has`, which must be a closed mask.
  Cut(const T& message, const Selection& selection, const FieldMask& has)
      : plan_(type_support<T>(), type_support<T>().closed(selection)) {
    const Encoded encoded(detail::TypeTable<T>::type, &message, has);
    const std::vector<std::byte> body = encoded.bytes();
    detail::SampleState state = encoded.state();
    state.body = body.data();
    detail::Projection projection;
    ok_ = projection.project(state, plan_);
    if (!ok_) return;
    bytes_ = gathered(projection);
    EXPECT_EQ(bytes_.size(), projection.bytes());
  }

  bool ok() const { return ok_; }
  const FieldMask& mask() const { return plan_.mask(); }
  const std::vector<std::byte>& bytes() const { return bytes_; }
  /// Returns the decoded part. Fields that were not selected have the values in `onto`.
  T decoded(T onto = {}) const { return decoded_from<T>(bytes_, mask(), std::move(onto)); }

 private:
  detail::ProjectionPlan plan_;
  std::vector<std::byte> bytes_;
  bool ok_ = false;
};

/// Compares the encoded message with the part, byte by byte. The failure message names the first byte and
/// field that differ.
template <class T>
::testing::AssertionResult is_encoded(const T& expected, const Cut<T>& cut) {
  using ::testing::AssertionFailure;
  if (!cut.ok()) return AssertionFailure() << "the projection was refused";
  const StructType& type = detail::TypeTable<T>::type;
  const std::vector<std::byte> bytes = Encoded(type, &expected, cut.mask()).bytes();
  if (bytes == cut.bytes()) return ::testing::AssertionSuccess();
  const auto at = std::mismatch(bytes.begin(), bytes.end(), cut.bytes().begin(), cut.bytes().end()).first;
  const T decoded = cut.decoded(expected);
  return AssertionFailure() << cut.bytes().size() << " bytes instead of " << bytes.size()
                            << ", different from byte " << at - bytes.begin()
                            << " on: " << same_value(type, &expected, &decoded).message();
}

}  // namespace sft::test
