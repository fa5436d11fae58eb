#include "tools/sft/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <string_view>

namespace sft::tool {

namespace {

constexpr std::size_t gap = 2;
// the limit for a column; longer cells, which files can have, are not padded
constexpr std::size_t width_most = 256;

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

/// Returns the widths of all columns but the last one, whose cells may be broken into lines.
Table::Widths Table::widths() const {
  Widths widths;
  for (std::size_t i = 0; i + 1 < headings_.size(); ++i) {
    std::size_t width = headings_[i].size();
    for (const auto& row : rows_) width = std::max(width, row[i].size());
    widths.push_back(std::min(width, width_most) + gap);
  }
  return widths;
}

bool Table::fits(std::size_t last_column, const Output& output) const {
  return std::ranges::all_of(
      rows_, [&](const auto& row) { return last_column + longest_word(row.back()) <= output.columns(); });
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
  const Widths all = widths();
  const std::size_t last_column = std::accumulate(all.begin(), all.end(), std::size_t{0});
  if (output.on_terminal() && !fits(last_column, output)) return print_paragraphs(output);
  const auto line = [&](const std::vector<std::string>& cells) {
    std::string text;
    for (std::size_t i = 0; i < all.size(); ++i) text += fmt::format("{:<{}}", cells[i], all[i]);
    return text + output.fitted(cells.back(), text.size(), text.size());
  };
  output.line(output.colored(line(headings_), Color::bold));
  for (const auto& row : rows_) output.line(line(row));
}

}  // namespace sft::tool
