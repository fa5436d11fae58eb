// UTF-8, which is what .msg files and the strings in them are.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace sft::msg {

/// Where the first byte is that is no UTF-8; npos: nowhere.
std::size_t find_invalid_utf8(std::string_view text);

/// False where Unicode has no such character.
bool append_utf8(char32_t character, std::string& text);

/// `text` in quotes for a message, shortened if it is long.
std::string shown(std::string_view text);

}  // namespace sft::msg
