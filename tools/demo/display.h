// The standard output of the demo. Only terminals get colours, and a status that stays in place.
#pragma once

#include <string>

#include "tools/demo/figures.h"
#include "tools/terminal/terminal.h"

namespace sft::demo {

class Display {
 public:
  Display() = default;
  ~Display();
  Display(const Display&) = delete;
  Display& operator=(const Display&) = delete;

  void say(const std::string& text);
  /// Says what the demo is about. On a terminal, the next text takes the place of this one. Text that is said
  /// already is not said again.
  void status(const std::string& text);
  /// Shows the final table, and explains it.
  void conclude(const RunFigures& run);

 private:
  void print(const std::string& lines);

  tool::Terminal terminal_;
  std::string status_;
};

}  // namespace sft::demo
