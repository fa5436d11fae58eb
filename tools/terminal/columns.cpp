#include "tools/terminal/columns.h"

namespace sft::tool {

namespace {
bool begins_character(char c) { return (static_cast<unsigned char>(c) & 0xc0U) != 0x80; }
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

std::vector<std::string> wrapped(std::string_view text, std::size_t columns) {
  std::vector<std::string> lines;
  while (columns_of(text) > columns) {
    const std::string_view fits = cut(text, columns);
    // A space right behind what fits ends a word as well.
    const std::size_t space = text.substr(0, fits.size() + 1).rfind(' ');
    const bool has_words = space != std::string_view::npos && space != 0;
    lines.emplace_back(has_words ? text.substr(0, space) : fits);
    text.remove_prefix(has_words ? space + 1 : fits.size());
  }
  lines.emplace_back(text);
  return lines;
}

}  // namespace sft::tool
