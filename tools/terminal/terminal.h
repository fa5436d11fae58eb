// The standard output. On a terminal, it has a size and colours. In a file or a pipe, text is plain and not
// shortened.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace sft::tool {

enum class Color : int { none = 0, red = 31, green = 32, yellow = 33, cyan = 36, bold = 1, dim = 2 };

class Terminal {
 public:
  /// `no_color` and the environment variable NO_COLOR (no-color.org) turn colours off. Without a terminal,
  /// there are no colours.
  explicit Terminal(bool no_color = false);

  /// Returns true if the standard output is a terminal.
  bool on_terminal() const { return terminal_; }
  /// Return the size of the terminal; 80 and 24 if it is not known.
  std::size_t columns() const;
  std::size_t rows() const;
  std::string colored(std::string_view text, Color color) const;
  /// Returns the text in lines that fit the terminal, as wrapped() makes them. Without a terminal, returns
  /// the whole text.
  std::string fitted(std::string_view text, std::size_t indent, std::size_t before = 0) const;

 private:
  bool terminal_;
  bool colors_;
};

}  // namespace sft::tool
