// Texts of others as people may see them: UTF-8 without what could act on a terminal.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace sft::core {

struct Character {
  std::size_t bytes = 0;  ///< 0: not UTF-8
  char32_t code = 0;
};

/// Returns the first character of a text that is not empty.
Character first_of(std::string_view text);

/// True of control characters, of what breaks a line, and of what turns the direction of the text that
/// follows.
bool acts_on_terminals(char32_t code);

/// Within quotation marks, cut where it is long, and with escapes for what is no text.
std::string in_quotes(std::string_view text);

}  // namespace sft::core
