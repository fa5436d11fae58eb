// Parses the strings of .msg files, which are in quotes of either kind, or without quotes.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

namespace sft::msg {

/// Returns the position after the closing quote of the string at the beginning of `text`; npos if there is
/// no closing quote. REQUIRES: `text` begins with a quote.
std::size_t quoted_end(std::string_view text);

/// Returns the string that `text` represents, with escapes resolved, as UTF-8 without NUL. The error says
/// what is wrong and what was expected.
tl::expected<std::string, std::string> parse_string(std::string_view text);

}  // namespace sft::msg
