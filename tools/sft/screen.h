// A terminal that shows a changing page, by plain escape sequences.
#pragma once

#include <termios.h>

#include <string>
#include <vector>

#include "tools/sft/output.h"

namespace sft::tool {

/// Uses the whole screen. The destructor restores the former contents.
class Screen {
 public:
  explicit Screen(Output& output);
  ~Screen();
  Screen(const Screen&) = delete;
  Screen& operator=(const Screen&) = delete;

  /// A line has one colour. Lines that are too long or too many for the screen are cut.
  struct Line {
    std::string text;
    Color color = Color::none;
  };
  void show(const std::vector<Line>& lines);

  /// Returns the descriptor from which keys are read, or -1 if the standard input is not a terminal.
  int keys() const { return keys_; }
  /// Returns true if the user has pressed the key. Discards all other keys.
  bool pressed(char key) const;

 private:
  Output& output_;
  int keys_ = -1;
  termios before_{};
};

}  // namespace sft::tool
