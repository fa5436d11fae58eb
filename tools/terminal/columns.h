// The width of text on a terminal, and text cut to a width. Characters that take two columns count as one.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace sft::tool {

/// The number of columns of one line of UTF-8 text.
std::size_t columns_of(std::string_view text);
/// The longest beginning of the text that takes at most `columns`.
std::string_view cut(std::string_view text, std::size_t columns);
/// The text itself if it takes no more columns, else its beginning and "...".
std::string shortened(std::string_view text, std::size_t columns);
/// The text in lines that take no more columns. It is broken between words, and within one that is too long.
std::vector<std::string> wrapped(std::string_view text, std::size_t columns);

}  // namespace sft::tool
