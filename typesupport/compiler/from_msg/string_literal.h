// Strings as .msg files write them: in quotes of either kind, or without.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

namespace sft::msg {

/// Behind the quote that ends the string which `text` begins with, a quote; npos: there is none.
std::size_t quoted_end(std::string_view text);

/// What the whole of `text` means, its escapes resolved. UTF-8 without NUL. The error says what is wrong and
/// what was expected.
tl::expected<std::string, std::string> parse_string(std::string_view text);

}  // namespace sft::msg
