// Prints rows of text in columns. If the terminal is too narrow, the cells of the last column are broken into
// lines, or each row becomes a paragraph.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "tools/sft/output.h"

namespace sft::tool {

class Table {
 public:
  explicit Table(std::vector<std::string> headings) : headings_(std::move(headings)) {}

  void add(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }
  bool empty() const { return rows_.empty(); }
  void print(Output& output) const;

 private:
  using Widths = std::vector<std::size_t>;

  Widths widths() const;
  bool fits(std::size_t last_column, const Output& output) const;
  void print_paragraphs(Output& output) const;

  std::vector<std::string> headings_;
  std::vector<std::vector<std::string>> rows_;
};

}  // namespace sft::tool
