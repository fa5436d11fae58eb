#include "tools/terminal/wrapped.h"

#include <algorithm>
#include <sstream>

namespace sft::tool {

std::string wrapped(std::string_view text, std::size_t columns, std::size_t indent, std::size_t before) {
  std::string out;
  std::size_t used = before;
  while (!text.empty()) {
    const std::size_t gap = std::min(text.find_first_not_of(' '), text.size());
    const std::size_t end = std::min(text.find(' ', gap), text.size());
    const bool begins = out.empty() || used <= indent;
    if (used + end > columns && !begins) {
      out += '\n' + std::string(indent, ' ') + std::string(text.substr(gap, end - gap));
      used = indent + end - gap;
    } else {
      out += text.substr(0, end);
      used += end;
    }
    text.remove_prefix(end);
  }
  return out;
}

std::vector<std::string> wrapped_lines(std::string_view text, std::size_t columns) {
  std::istringstream all(wrapped(text, columns));
  std::vector<std::string> lines;
  for (std::string line; std::getline(all, line);) lines.push_back(std::move(line));
  if (lines.empty()) lines.emplace_back();
  return lines;
}

}  // namespace sft::tool
