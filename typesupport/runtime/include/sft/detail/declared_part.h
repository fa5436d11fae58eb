// Parts of fields that a program declares when it is compiled (selection.md, "Parts"):
//
//   using F = PointCloud2::Field;
//   node.subscriber<PointCloud2, F::header.stamp | F::data.channels<"x", "y", "z">>("points")
//   node.subscriber<LaserScan, F::angle_min | F::angle_increment | F::ranges.every(4)>("scan")
//   node.subscriber<OccupancyGrid, F::info | F::data.rows(10, 20).columns(0, 640, 2)>("map")
//
// A mistake that is visible in the declaration does not compile: the compiler names a function that is not
// constexpr, and the name of the function describes the mistake. Other mistakes are errors of
// Node::subscriber().
//
// Two compilers limit how this file is written. g++ 14 refuses concepts of ranges and iterators in
// compile-time code here if a program has included certain headers before. So there are loops in place of
// algorithms. Clang 14 and 15 refuse a consteval function that passes its parameters to another consteval
// function. So all functions are constexpr. They are evaluated at compile time anyway, since they are used
// in template arguments.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace sft::detail {

/// Every step-th index of [begin, end). If all indices are kept, all members are 0, because compilers leave
/// zeros out of the names of functions.
struct DeclaredRange {
  std::uint32_t begin = 0;
  std::uint32_t end = 0;   ///< the first index after the range; 0: the range has no end
  std::uint32_t step = 0;  ///< the step; 0: a step of 1

  friend constexpr bool operator==(const DeclaredRange&, const DeclaredRange&) = default;
};

/// The part of one leaf. If all members are 0, the object is unused.
struct DeclaredPart {
  /// The maximum length of all names together, with a comma after each name and a NUL at the end.
  static constexpr std::size_t channel_bytes_max = 128;

  std::uint32_t leaf = 0;
  DeclaredRange rows{};
  DeclaredRange columns{};
  std::array<char, channel_bytes_max> channels{};

  constexpr bool is_whole() const { return rows == DeclaredRange{} && columns == rows && channels[0] == 0; }
  friend constexpr bool operator==(const DeclaredPart&, const DeclaredPart&) = default;
};

/// The maximum number of parts in one declaration.
inline constexpr std::size_t declared_parts_max = 4;
using DeclaredParts = std::array<DeclaredPart, declared_parts_max>;

/// A text as a template argument.
template <std::size_t Bytes>
struct NameText {
  std::array<char, Bytes> bytes{};
  constexpr NameText(const char (&text)[Bytes]) {  // NOLINT(google-explicit-constructor)
    for (std::size_t i = 0; i < Bytes; ++i) bytes[i] = text[i];
  }
  static constexpr std::size_t size() { return Bytes - 1; }  // not counting the NUL at the end
};

// Functions whose names describe mistakes in a declaration. They are not constexpr: a call during constant
// evaluation does not compile, and the compiler's message shows the name.
inline void a_range_has_an_index_and_a_step() {}
inline void a_name_of_a_channel_has_a_character_and_neither_comma_nor_brace() {}
inline void names_of_channels_are_too_long_together() {}
inline void a_range_is_given_twice() {}
inline void a_field_has_two_parts() {}
inline void there_are_too_many_parts() {}

constexpr DeclaredRange declared_range(std::uint32_t begin, std::uint32_t end, std::uint32_t step) {
  if (step == 0 || (end != 0 && end <= begin)) a_range_has_an_index_and_a_step();
  return {begin, end, step == 1 ? 0 : step};
}

/// The names of channels, each followed by a comma.
struct ChannelNames {
  std::array<char, DeclaredPart::channel_bytes_max> text{};
  std::size_t end = 0;

  template <std::size_t Bytes>
  constexpr void add(const NameText<Bytes>& name) {
    if (name.size() == 0) a_name_of_a_channel_has_a_character_and_neither_comma_nor_brace();
    if (end + name.size() + 1 >= text.size()) names_of_channels_are_too_long_together();
    for (std::size_t i = 0; i < name.size(); ++i) {
      const char c = name.bytes[i];
      if (c == ',' || c == '{' || c == '}' || c == 0)
        a_name_of_a_channel_has_a_character_and_neither_comma_nor_brace();
      text[end++] = c;
    }
    text[end++] = ',';
  }
};

template <NameText... Names>
constexpr std::array<char, DeclaredPart::channel_bytes_max> declared_channels() {
  ChannelNames names;
  (names.add(Names), ...);
  return names.text;
}

}  // namespace sft::detail
