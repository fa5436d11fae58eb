// Text in lines that a terminal of 80 columns shows in full.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace sft::demo {

/// One column stays free: terminals differ in what they do after a character in the last one.
inline constexpr std::size_t columns_max = 79;

/// Breaks at spaces; a word that is longer than a line is a line of its own.
std::vector<std::string> wrap(std::string_view text, std::size_t columns = columns_max);

/// The text itself if it fits, else its beginning and "...".
std::string shorten(std::string_view text, std::size_t columns);

}  // namespace sft::demo
