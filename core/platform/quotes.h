// Makes texts from other processes safe to print: the results are UTF-8 without characters that could
// control a terminal.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace sft::core {

struct Character {
  std::size_t bytes = 0;  ///< the length of the character in bytes; 0: the text is not UTF-8
  char32_t code = 0;
};

/// Returns the first character of a text, which must not be empty.
Character first_of(std::string_view text);

/// Returns true for control characters, line breaks, and characters that change the direction of the text
/// that follows.
bool acts_on_terminals(char32_t code);

/// Returns the text within quotation marks. A long text is cut, and characters that cannot be printed are
/// replaced by escapes.
std::string in_quotes(std::string_view text);

}  // namespace sft::core
