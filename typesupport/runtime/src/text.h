// Text of unknown origin: is it UTF-8, can it be shown, what may have been meant?
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace sft::detail {

struct CodePoint {
  std::uint32_t value = 0;
  std::size_t bytes = 0;  ///< 0: what stands there is not UTF-8
};

/// The first code point of a text that is not empty. Surrogates, overlong forms and what lies beyond U+10FFFF
/// are not UTF-8.
CodePoint first_code_point(std::string_view text);

/// Control characters, and what is not a character: nothing to be sent to a terminal.
bool is_control(std::uint32_t code_point);

/// UTF-8 without control characters.
bool is_printable(std::string_view text);

/// Levenshtein distance: how unlike two names are.
std::size_t edit_distance(std::string_view a, std::string_view b);

}  // namespace sft::detail
