// Parts of fields that a program declares when it is compiled (selection.md, "Parts"):
//
//   using F = PointCloud2::Field;
//   node.subscriber<PointCloud2, F::header.stamp | F::data.channels<"x", "y", "z">>("points")
//   node.subscriber<LaserScan, F::angle_min | F::angle_increment | F::ranges.every(4)>("scan")
//   node.subscriber<OccupancyGrid, F::info | F::data.rows(10, 20).columns(0, 640, 2)>("map")
//
// A mistake that can be seen in the declaration does not compile: the name of the function that is not
// constant says what is wrong. Others are errors of Node::subscriber().
#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <utility>

namespace sft::detail {

/// Every step-th index of [begin, end). All of its members are 0 if it keeps all, since the compiler leaves
/// zeros out of the names of functions.
struct DeclaredRange {
  std::uint32_t begin = 0;
  std::uint32_t end = 0;   ///< 0: as many as there are
  std::uint32_t step = 0;  ///< 0: 1

  friend constexpr bool operator==(const DeclaredRange&, const DeclaredRange&) = default;
};

/// The part of one leaf; without a part if all of its members are 0.
struct DeclaredPart {
  static constexpr std::size_t channel_bytes_max =
      128;  ///< of all names, with a comma behind each, and a NUL

  std::uint32_t leaf = 0;
  DeclaredRange rows{};
  DeclaredRange columns{};
  std::array<char, channel_bytes_max> channels{};

  constexpr bool is_whole() const { return rows == DeclaredRange{} && columns == rows && channels[0] == 0; }
  friend constexpr bool operator==(const DeclaredPart&, const DeclaredPart&) = default;
};

/// The parts in one declaration.
inline constexpr std::size_t declared_parts_max = 4;
using DeclaredParts = std::array<DeclaredPart, declared_parts_max>;

/// A text as a template argument.
template <std::size_t Bytes>
struct NameText {
  std::array<char, Bytes> bytes{};
  consteval NameText(const char (&text)[Bytes]) {  // NOLINT(google-explicit-constructor)
    std::copy_n(text, Bytes, bytes.begin());
  }
  constexpr std::string_view view() const { return {bytes.data(), Bytes - 1}; }
};

// Names of mistakes. They are no constant expressions.
inline void a_range_has_an_index_and_a_step() {}
inline void a_name_of_a_channel_has_a_character_and_neither_comma_nor_brace() {}
inline void names_of_channels_are_too_long_together() {}
inline void a_range_is_given_twice() {}
inline void a_field_has_two_parts() {}
inline void there_are_too_many_parts() {}

consteval DeclaredRange declared_range(std::uint32_t begin, std::uint32_t end, std::uint32_t step) {
  if (step == 0 || (end != 0 && end <= begin)) a_range_has_an_index_and_a_step();
  return {begin, end, step == 1 ? 0 : step};
}

template <NameText... Names>
consteval std::array<char, DeclaredPart::channel_bytes_max> declared_channels() {
  std::array<char, DeclaredPart::channel_bytes_max> text{};
  std::size_t end = 0;
  for (const std::string_view name : {Names.view()...}) {
    if (name.empty() || name.find_first_of(std::string_view(",{}\0", 4)) != name.npos)
      a_name_of_a_channel_has_a_character_and_neither_comma_nor_brace();
    if (end + name.size() + 1 >= text.size()) names_of_channels_are_too_long_together();
    end = static_cast<std::size_t>(std::ranges::copy(name, text.begin() + end).out - text.begin());
    text[end++] = ',';
  }
  return text;
}

}  // namespace sft::detail
