#include "examples/demo/text_lines.h"

namespace sft::demo {

std::vector<std::string> wrap(std::string_view text, std::size_t columns) {
  std::vector<std::string> lines;
  while (text.size() > columns) {
    std::size_t end = text.rfind(' ', columns);
    if (end == text.npos || end == 0) end = text.find(' ', columns);
    if (end == text.npos) break;
    lines.emplace_back(text.substr(0, end));
    text.remove_prefix(end + 1);
  }
  lines.emplace_back(text);
  return lines;
}

std::string shorten(std::string_view text, std::size_t columns) {
  constexpr std::string_view ellipsis = "...";
  if (text.size() <= columns) return std::string(text);
  if (columns <= ellipsis.size()) return std::string(text.substr(0, columns));
  return std::string(text.substr(0, columns - ellipsis.size())) + std::string(ellipsis);
}

}  // namespace sft::demo
