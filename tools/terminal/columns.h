// Computes the width of UTF-8 text on a terminal, and breaks text into lines of a given width. Every
// character counts as one column.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace sft::tool {

/// Returns the width of the text, as one line, in columns.
std::size_t columns_of(std::string_view text);
/// Returns the longest beginning of the text that takes at most `columns` columns.
std::string_view cut(std::string_view text, std::size_t columns);
/// Returns the whole text if it takes at most `columns` columns, or else its beginning and "...".
std::string shortened(std::string_view text, std::size_t columns);

enum class LongWords { broken, whole };
/// Returns the text in lines of at most `columns` columns, broken between words. `long_words` decides about
/// a word that is longer than a line: it is broken as well, or it is a line of its own.
std::vector<std::string> lines_of(std::string_view text, std::size_t columns, LongWords long_words);
/// Returns the lines as one text with line breaks. Words are not broken. The first line begins after `before`
/// columns, and each other line with `indent` spaces.
std::string wrapped(std::string_view text, std::size_t columns, std::size_t indent = 0,
                    std::size_t before = 0);

}  // namespace sft::tool
