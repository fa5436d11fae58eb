// Checks text of unknown origin, and computes a distance between names, with which errors suggest a similar
// name.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace sft::detail {

struct CodePoint {
  std::uint32_t value = 0;
  std::size_t bytes = 0;  ///< number of bytes of the code point; 0: the text does not begin with UTF-8
};

/// Returns the first code point of a text that is not empty. Surrogates, overlong forms and code points
/// beyond U+10FFFF are not UTF-8.
CodePoint first_code_point(std::string_view text);

/// Returns true for control characters and for code points that are not characters: neither must be sent to a
/// terminal.
bool is_control(std::uint32_t code_point);

/// Returns true for UTF-8 without control characters.
bool is_printable(std::string_view text);

/// Returns the Levenshtein distance of two names.
std::size_t edit_distance(std::string_view a, std::string_view b);

}  // namespace sft::detail
