// Parts of parts. A message is cut in two steps: the second step takes a part of the first step's result.
// The same message is also cut in one step, by the selection that combines the selections of both steps.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sft/detail/project.h"
#include "sft/detail/walk.h"
#include "sft/type_support.h"
#include "tests/support/cut.h"
#include "tests/support/cut_reference.h"
#include "tests/support/encoded.h"
#include "tests/support/owned_value.h"
#include "tests/support/random_layouts.h"
#include "tests/support/random_value.h"

#ifndef SFT_TEST_ROUNDS
#define SFT_TEST_ROUNDS 1000
#endif

namespace sft {

/// A message, or a part that selections took from it, encoded in memory of exactly its size.
template <class T>
class Taken {
 public:
  explicit Taken(const T& message) : Taken(message, FieldMask::full(detail::leaf_count_of<T>)) {}
  /// Encodes the fields of the message that are in `mask`, which must be closed.
  Taken(const T& message, const FieldMask& mask)
      : mask_(mask), bytes_(test::Encoded(detail::TypeTable<T>::type, &message, mask).bytes()) {}

  /// Returns the part of this message that the selection takes. The test fails if the selection is refused.
  Taken part(const Selection& selection) const {
    const TypeSupport& type = type_support<T>();
    const detail::ProjectionPlan plan(type, type.closed(selection));
    std::vector<std::uint32_t> index(type.index_slots());
    const detail::SampleState state{.body = bytes_.data(),
                                    .body_bytes = static_cast<std::uint32_t>(bytes_.size()),
                                    .index = index.data(),
                                    .mask = &mask_};
    EXPECT_EQ(detail::build_index(state, type.type(), index), detail::WalkStatus::ok);
    detail::Projection projection;
    EXPECT_TRUE(projection.project(state, plan));
    return Taken(plan.mask(), test::gathered(projection));
  }

  const FieldMask& mask() const { return mask_; }
  const std::vector<std::byte>& bytes() const { return bytes_; }
  /// Returns the message. Fields that are not in the mask have their default values.
  T message() const { return test::decoded_from<T>(bytes_, mask_); }

 private:
  Taken(const FieldMask& mask, std::vector<std::byte> bytes) : mask_(mask), bytes_(std::move(bytes)) {}

  FieldMask mask_;
  std::vector<std::byte> bytes_;
};

/// Compares the fields byte by byte. The failure message names the first field that differs.
template <class T>
::testing::AssertionResult is_same(const Taken<T>& in_two_steps, const Taken<T>& in_one) {
  using ::testing::AssertionFailure;
  if (!(in_two_steps.mask() == in_one.mask())) return AssertionFailure() << "other fields";
  if (in_two_steps.bytes() == in_one.bytes()) return ::testing::AssertionSuccess();
  const T two = in_two_steps.message(), one = in_one.message();
  return AssertionFailure() << in_two_steps.bytes().size() << " bytes in two steps, and "
                            << in_one.bytes().size() << " in one: "
                            << test::same_value(detail::TypeTable<T>::type, &two, &one).message();
}

/// Two selections, applied one after the other, and the selection that combines both.
struct Steps {
  Selection first;
  Selection second;
  Selection both;
};

/// Returns the part that is selected of the fields in `leaves`, which share a layout. If these fields are
/// requested with different parts, returns the part that is the whole field.
inline Selection::Part common_part(const Selection& selection, std::span<const std::uint32_t> leaves) {
  std::optional<Selection::Part> common;
  for (const std::uint32_t leaf : leaves) {
    if (!selection.mask().contains(leaf)) continue;
    Selection::Part part = selection.part(leaf) == nullptr ? Selection::Part{} : *selection.part(leaf);
    part.leaf = 0;
    if (common && part != *common) return {};
    common = part;
  }
  return common.value_or(Selection::Part{});
}

/// Combines the parts of two steps. If no channel is in both parts, the result names a channel that no
/// message has.
inline Selection::Part together(const Selection::Part& first, const Selection::Part& second) {
  Selection::Part both{.rows = first.rows.then(second.rows), .columns = first.columns.then(second.columns)};
  both.channels = first.channels.empty() ? second.channels : first.channels;
  if (first.channels.empty() || second.channels.empty()) return both;
  both.channels.clear();
  std::ranges::set_intersection(first.channels, second.channels, std::back_inserter(both.channels));
  if (both.channels.empty()) both.channels = {"in neither step"};
  return both;
}

/// Returns the part once for each of the fields in `leaves` that is selected.
inline std::vector<Selection::Part> parts_of(const Selection& selection,
                                             std::span<const std::uint32_t> leaves, Selection::Part part) {
  std::vector<Selection::Part> parts;
  for (const std::uint32_t leaf : leaves) {
    part.leaf = leaf;
    if (selection.mask().contains(leaf)) parts.push_back(part);
  }
  return parts;
}

/// Returns the product of both steps, divided by the step of the combined part. The quotient exceeds 1 only
/// if the part has a single index, because such a part does not keep its step.
inline double forgotten_step(const Selection::Range& first, const Selection::Range& second,
                             const Selection::Range& both) {
  return static_cast<double>(first.step) * second.step / both.step;
}

/// Returns true if the data of a message is too short for the number and size of its cells.
inline bool lacks_room(std::uint64_t rows, std::uint64_t columns, std::uint64_t cell_bytes,
                       std::uint64_t row_bytes, std::uint64_t data_bytes) {
  if (rows == 0 || columns == 0) return false;
  const std::uint64_t row_end = columns * cell_bytes;
  if (cell_bytes == 0 || row_end > data_bytes) return true;
  if (data_bytes % rows == 0 && data_bytes / rows == row_end) return false;  // here row_bytes does not matter
  return rows > 1 && (row_end > row_bytes || (rows - 1) * row_bytes > data_bytes - row_end);
}

class PartOfPartTest : public test::RandomTest {
 protected:
  using Part = Selection::Part;
  using Range = Selection::Range;

  static int rounds() { return static_cast<int>(test::test_rounds(SFT_TEST_ROUNDS)) / 2; }

  template <class T>
  static std::uint32_t leaf(std::string_view path) {
    return static_cast<std::uint32_t>(*type_support<T>().find(path).value().begin());
  }

  /// Returns a range that mostly has some indices. Sometimes the range is empty, begins after the last
  /// index, or has a step larger than `count`.
  Range any_range(std::uint32_t count) {
    if (count > 0 && !layouts.one_in(3)) return layouts.range_with_some(count);
    Range range = layouts.range(count);
    switch (layouts.below(12)) {
      case 0:
        return {.begin = count + layouts.below(3), .step = 1 + layouts.below(3)};
      case 1:
        return {.begin = 1, .end = 1};
      case 2:
        range.step = count + 1 + layouts.below(3);
        return range;
      case 3:
        range.step = Range::no_end;
        return range;
      default:
        return range;
    }
  }
  Part any_part(std::uint32_t rows, std::uint32_t columns) {
    return {.rows = any_range(rows), .columns = any_range(columns)};
  }

  /// Returns both steps, with random other fields. The first step takes all fields that the second step
  /// needs. `make_both` returns the combined parts of both selections.
  template <class T, class MakeBoth>
  Steps steps_of(const std::vector<Part>& first, const std::vector<Part>& second, MakeBoth make_both) {
    const TypeSupport& type = type_support<T>();
    const auto selection = [](const FieldMask& mask, const std::vector<Part>& parts) {
      return Selection::make(mask, parts, {}).value();
    };
    const Selection asked = selection(values.mask(type.leaves()), second);
    const Selection before = selection(type.closed(asked).mask() | values.mask(type.leaves()), first);
    const std::vector<Part> parts = make_both(before, asked);
    // If one of the selections needs a field in addition to its part, the other selections have that field,
    // too.
    const FieldMask mask = type.closed(asked).mask() | type.closed(selection(asked.mask(), parts)).mask();
    return {selection(before.mask() | mask, first), selection(mask, second), selection(mask, parts)};
  }
  /// Returns the steps for one field with a layout of its own.
  template <class T>
  Steps steps_of(std::string_view path, Part first, Part second) {
    first.leaf = second.leaf = leaf<T>(path);
    return steps_of<T>({first}, {second}, [&](const Selection& before, const Selection& behind) {
      const std::vector<std::uint32_t> leaves{first.leaf};
      return parts_of(behind, leaves, together(common_part(before, leaves), common_part(behind, leaves)));
    });
  }
  /// Returns random steps for a field with that number of rows and columns.
  template <class T>
  Steps any_steps(std::string_view path, std::uint32_t rows, std::uint32_t columns) {
    const Part first = any_part(rows, columns);
    return steps_of<T>(path, first, any_part(first.rows.size_of(rows), first.columns.size_of(columns)));
  }

  template <class T>
  static Steps steps_by_text(std::string_view first, std::string_view second, std::string_view both) {
    const auto parsed = [](std::string_view text) { return type_support<T>().parse_selection(text).value(); };
    return {parsed(first), parsed(second), parsed(both)};
  }
  template <class T>
  static std::string words(const Steps& steps) {
    const auto text = [](const Selection& s) { return "'" + type_support<T>().format_selection(s) + "'"; };
    return text(steps.first) + " and then " + text(steps.second) + ", or " + text(steps.both);
  }

  /// Returns the part that one step takes. The test fails if two steps give other bytes than one step.
  template <class T>
  static Taken<T> expect_same_bytes(const T& message, const Steps& steps) {
    const Taken<T> whole(message);
    const Taken<T> one = whole.part(steps.both);
    EXPECT_TRUE(is_same(whole.part(steps.first).part(steps.second), one)) << words<T>(steps);
    return one;
  }

  /// Returns small natural numbers.
  template <class Number>
  std::vector<Number> numbers(std::size_t count) {
    std::vector<Number> result(count);
    for (Number& number : result) number = static_cast<Number>(layouts.below(100));
    return result;
  }

  test::RandomLayouts layouts{random};
  test::RandomValues values{random};
};

}  // namespace sft
