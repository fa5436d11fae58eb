// The standard output of the demo: a table that stays in place on a terminal, and a line now and then
// elsewhere. Only terminals get colours. No line has more than columns_max characters, unless a single word
// is longer.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tools/demo/screen/figures.h"
#include "tools/terminal/terminal.h"

namespace sft::demo {

class Display {
 public:
  void say(const std::string& text);
  /// Says what the demo waits for: at once when it begins to wait for something else, and then once in a
  /// second. `what` is a sentence without its full stop. Call this several times in a second.
  void waiting(std::string_view what, Clock::time_point now);
  /// Replaces the table that the previous call showed.
  void show(const RunFigures& figures, double elapsed_s);
  /// Shows the final table, and explains it.
  void conclude(const RunFigures& figures);

 private:
  std::size_t columns_shown() const;
  std::string table(const RunFigures& figures, std::size_t columns) const;
  void replace(const std::string& lines, std::size_t count);

  tool::Terminal terminal_;
  std::size_t shown_lines_ = 0;  // lines that the next text on the terminal replaces
  double next_progress_s_ = 1;
  std::string waits_for_;
  Clock::time_point waits_since_, said_at_;
};

}  // namespace sft::demo
