// Standard output: a table that stays in place on a terminal, a line now and then elsewhere. Colours are for
// terminals only. No line has more than columns_max characters, but for words that are longer.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tools/demo/screen/figures.h"
#include "tools/demo/screen/wait_notice.h"

namespace sft::demo {

class Display {
 public:
  /// Colours are used if they are wanted and this is a terminal.
  explicit Display(bool colours_wanted);

  void say(const std::string& text);
  /// What is being waited for, a sentence without its end. To be called several times a second.
  void waiting(std::string_view what, WaitNotice::Clock::time_point now);
  /// Replaces what the previous call showed.
  void show(const RunFigures& figures, double elapsed_s);
  /// The table as it is to stay, and what it means.
  void conclude(const RunFigures& figures);

 private:
  enum class Style { plain, head, pitch };
  std::string painted(const std::string& line, Style style) const;
  std::string painted_table(const RunFigures& figures, std::size_t columns) const;
  void replace(const std::string& lines, std::size_t count);

  bool terminal_;
  bool colours_;
  std::size_t shown_lines_ = 0;  // on the terminal, to be replaced
  double next_progress_s_ = 1;
  WaitNotice notice_;
};

}  // namespace sft::demo
