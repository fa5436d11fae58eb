// A terminal that shows a changing page, by plain escape sequences.
#pragma once

#include <string>
#include <vector>

#include "tools/sft/keys.h"
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

  const Keys& keys() const { return keys_; }

 private:
  Output& output_;
  Keys keys_{};
};

}  // namespace sft::tool
