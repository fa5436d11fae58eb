// Functions for UTF-8, the encoding of .msg files and of the strings in them.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace sft::msg {

/// Returns the position of the first byte that is not UTF-8; npos if all of `text` is UTF-8.
std::size_t find_invalid_utf8(std::string_view text);

/// Appends a character. Returns false if Unicode has no such character.
bool append_utf8(char32_t character, std::string& text);

/// Returns `text` in quotes for error messages, shortened if it is long.
std::string shown(std::string_view text);

}  // namespace sft::msg
