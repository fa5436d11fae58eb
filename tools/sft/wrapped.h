// Sentences in lines of some width.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace sft::tool {

/// The text with line breaks in the place of spaces, so that no line has more than `columns` bytes, but for
/// words that are longer themselves. The first line begins behind `before` bytes that stand there already,
/// and each other one with `indent` spaces.
std::string wrapped(std::string_view text, std::size_t columns, std::size_t indent = 0,
                    std::size_t before = 0);

}  // namespace sft::tool
