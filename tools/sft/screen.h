// A terminal that shows a page which changes, by plain escape sequences.
#pragma once

#include <termios.h>

#include <string>
#include <vector>

#include "tools/sft/output.h"

namespace sft::tool {

/// Takes the whole screen, and gives it back as it was.
class Screen {
 public:
  explicit Screen(Output& output);
  ~Screen();
  Screen(const Screen&) = delete;
  Screen& operator=(const Screen&) = delete;

  /// Lines that are too long or too many for the screen are cut; a colour is for a whole line.
  struct Line {
    std::string text;
    Color color = Color::none;
  };
  void show(const std::vector<Line>& lines);

  /// Where keys come from; -1: from nowhere.
  int keys() const { return keys_; }
  /// Whether the user has pressed this key. All others that were pressed are passed over.
  bool pressed(char key) const;

 private:
  Output& output_;
  int keys_ = -1;
  termios before_{};
};

}  // namespace sft::tool
