// The standard output of the demo: a table that stays in place on a terminal, and a line now and then
// elsewhere. Only terminals get colours. No line has more than columns_max characters, unless a single word
// is longer.
#pragma once

#include <chrono>
#include <string>

#include "tools/demo/screen/figures.h"
#include "tools/terminal/terminal.h"

namespace sft::demo {

class Display {
 public:
  void say(const std::string& text);
  /// Says what the demo waits for, at once and then once in a second: "Not served yet: health ... 3 s".
  /// `what` is the sentence without its end. Call this several times in a second.
  void waiting(const std::string& what, Clock::time_point now = Clock::now());
  /// Replaces the table that the previous call showed.
  void show(const RunFigures& figures, double elapsed_s);
  /// Shows the final table, and explains it.
  void conclude(const RunFigures& figures);

 private:
  std::size_t columns_shown() const;
  std::string table(const RunFigures& figures, std::size_t columns) const;
  void replace(const std::string& lines, std::size_t count);

  tool::Terminal terminal_;
  std::size_t shown_lines_ = 0;  // that the next text on the terminal replaces
  double next_progress_s_ = 1;
  std::string awaited_;
  Clock::time_point waiting_since_;
  Clock::time_point said_;
};

}  // namespace sft::demo
