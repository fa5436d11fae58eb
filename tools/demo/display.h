// The standard output of the demo. Colours, and a status line that is replaced in place, are used only on
// terminals.
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
  /// Shows what the demo does at present. On a terminal, the next text replaces this text. Text that is
  /// already shown is not printed again.
  void status(const std::string& text);
  /// Shows the final table, and explains it.
  void conclude(const RunFigures& run);

 private:
  void print(const std::string& lines);

  tool::Terminal terminal_;
  std::string status_;
};

}  // namespace sft::demo
