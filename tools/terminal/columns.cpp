#include "tools/terminal/columns.h"

#include <algorithm>

namespace sft::tool {

namespace {

bool begins_character(char c) { return (static_cast<unsigned char>(c) & 0xc0U) != 0x80; }

std::vector<std::string> broken(std::string_view text, std::size_t first_columns, std::size_t columns,
                                LongWords long_words) {
  constexpr auto none = std::string_view::npos;
  std::vector<std::string> lines;
  for (std::size_t width = first_columns; columns_of(text) > width; width = columns) {
    const std::size_t fits = cut(text, width).size();
    // A space directly after the text that fits ends a word as well.
    std::size_t space = text.substr(0, fits + 1).rfind(' ');
    if (space == 0) space = none;
    if (space == none && long_words == LongWords::whole) {
      space = text.find(' ', std::max<std::size_t>(fits, 1));
      if (space == none) break;
    }
    lines.emplace_back(text.substr(0, space == none ? fits : space));
    text.remove_prefix(space == none ? fits : space + 1);
  }
  lines.emplace_back(text);
  return lines;
}

}  // namespace

std::size_t columns_of(std::string_view text) {
  std::size_t columns = 0;
  for (const char c : text) columns += begins_character(c) ? 1 : 0;
  return columns;
}

std::string_view cut(std::string_view text, std::size_t columns) {
  std::size_t shown = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (begins_character(text[i]) && shown++ == columns) return text.substr(0, i);
  }
  return text;
}

std::string shortened(std::string_view text, std::size_t columns) {
  constexpr std::string_view ellipsis = "...";
  if (columns_of(text) <= columns) return std::string(text);
  if (columns <= ellipsis.size()) return std::string(cut(text, columns));
  return std::string(cut(text, columns - ellipsis.size())) + std::string(ellipsis);
}

std::vector<std::string> lines_of(std::string_view text, std::size_t columns, LongWords long_words) {
  return broken(text, columns, columns, long_words);
}

std::string wrapped(std::string_view text, std::size_t columns, std::size_t indent, std::size_t before) {
  const auto behind = [&](std::size_t used) { return columns - std::min(columns, used); };
  std::string out;
  for (const std::string& line : broken(text, behind(before), behind(indent), LongWords::whole)) {
    out += (out.empty() ? "" : '\n' + std::string(indent, ' ')) + line;
  }
  return out;
}

}  // namespace sft::tool
