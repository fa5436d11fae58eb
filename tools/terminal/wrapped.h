// Breaks sentences into lines.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace sft::tool {

/// Replaces spaces by line breaks, so that no line has more than `columns` bytes. A longer word has a line of
/// its own. The first line begins behind `before` bytes that the caller has printed, and each other line with
/// `indent` spaces.
std::string wrapped(std::string_view text, std::size_t columns, std::size_t indent = 0,
                    std::size_t before = 0);
/// The lines that wrapped() makes without indent.
std::vector<std::string> wrapped_lines(std::string_view text, std::size_t columns);

}  // namespace sft::tool
