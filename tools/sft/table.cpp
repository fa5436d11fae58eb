#include "tools/sft/table.h"

#include <fmt/format.h>

#include <algorithm>

namespace sft::tool {

std::string Table::line(const std::vector<std::string>& cells) const {
  std::string text;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    std::size_t width = headings_[i].size();
    for (const auto& row : rows_) width = std::max(width, row[i].size());
    text += fmt::format("{:<{}}", cells[i], i + 1 == cells.size() ? 0 : width + 2);
  }
  return text;
}

void Table::print(Output& output) const {
  output.line(output.colored(line(headings_), Color::bold));
  for (const auto& row : rows_) output.line(line(row));
}

}  // namespace sft::tool
