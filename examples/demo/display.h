// Standard output: a table that stays in place on a terminal, a line now and then elsewhere.
#pragma once

#include <string>

#include "examples/demo/figures.h"

namespace sft::demo {

class Display {
 public:
  Display();

  void say(const std::string& line);
  /// Replaces what the previous call showed.
  void show(const RunFigures& figures, double elapsed_s);
  /// The table as it is to stay, and what it means.
  void conclude(const RunFigures& figures);

 private:
  void replace(const std::string& lines, std::size_t count);

  bool terminal_;
  std::size_t shown_lines_ = 0;  // of the table on the terminal
  double next_progress_s_ = 1;
};

}  // namespace sft::demo
