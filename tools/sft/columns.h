// How wide text is, and text that is to be no wider. Characters that take two columns count as one.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace sft::tool {

/// Of UTF-8 text in one line.
std::size_t columns_of(std::string_view text);
/// The beginning of the text that takes no more columns.
std::string_view cut(std::string_view text, std::size_t columns);
/// The text in lines that take no more columns. It is broken between words, and within one that is too long.
std::vector<std::string> wrapped(std::string_view text, std::size_t columns);

}  // namespace sft::tool
