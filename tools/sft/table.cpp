#include "tools/sft/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

namespace sft::tool {

namespace {

constexpr std::size_t gap = 2;

std::size_t longest_word(std::string_view text) {
  std::size_t longest = 0;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(' '), text.size());
    longest = std::max(longest, end);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return longest;
}

}  // namespace

std::size_t Table::width_of(std::size_t column) const {
  std::size_t width = headings_[column].size();
  for (const auto& row : rows_) width = std::max(width, row[column].size());
  return width + gap;
}

/// Returns the offset of the last column in a line, whose cells may be broken into lines.
std::size_t Table::last_column() const {
  std::size_t at = 0;
  for (std::size_t i = 0; i + 1 < headings_.size(); ++i) at += width_of(i);
  return at;
}

std::string Table::line(const std::vector<std::string>& cells, const Output& output) const {
  std::string text;
  for (std::size_t i = 0; i + 1 < cells.size(); ++i) text += fmt::format("{:<{}}", cells[i], width_of(i));
  return text + output.fitted(cells.back(), text.size(), text.size());
}

bool Table::fits(const Output& output) const {
  const std::size_t at = last_column();
  return std::ranges::all_of(
      rows_, [&](const auto& row) { return at + longest_word(row.back()) <= output.columns(); });
}

/// Prints each row as a paragraph.
void Table::print_paragraphs(Output& output) const {
  const auto longest = std::ranges::max(headings_, {}, &std::string::size).size();
  for (const auto& row : rows_) {
    output.line(row.front());
    for (std::size_t i = 1; i < row.size(); ++i) {
      const std::string heading = fmt::format("  {:<{}}", headings_[i], longest + gap);
      output.line(output.colored(heading, Color::bold) +
                  output.fitted(row[i], heading.size(), heading.size()));
    }
  }
}

void Table::print(Output& output) const {
  if (output.on_terminal() && !fits(output)) return print_paragraphs(output);
  output.line(output.colored(line(headings_, output), Color::bold));
  for (const auto& row : rows_) output.line(line(row, output));
}

}  // namespace sft::tool
