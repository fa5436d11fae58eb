#include "examples/demo/display.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>

#include "examples/demo/report.h"

namespace sft::demo {

namespace {

/// A longer line would wrap, and the table could not be replaced.
std::size_t terminal_columns() {
  winsize size{};
  return ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

}  // namespace

Display::Display() : terminal_(isatty(STDOUT_FILENO) != 0) {}

void Display::say(const std::string& line) {
  std::puts(line.c_str());
  std::fflush(stdout);
}

void Display::replace(const std::string& lines, std::size_t count) {
  if (shown_lines_ > 0) std::printf("\x1b[%zuA\x1b[J", shown_lines_);  // up to its first line, and clear
  std::fputs(lines.c_str(), stdout);
  std::fflush(stdout);
  shown_lines_ = count;
}

void Display::show(const RunFigures& figures, double elapsed_s) {
  if (!terminal_) {
    if (elapsed_s < next_progress_s_) return;
    next_progress_s_ = std::floor(elapsed_s) + 1;
    say(format_progress(figures, elapsed_s));
    return;
  }
  const std::size_t columns = terminal_columns();
  std::string text =
      fmt::format("\n{:.1f} s, {} point clouds published\n", elapsed_s, format_count(figures.samples));
  const std::vector<std::string> table = format_table(figures);
  for (const std::string& line : table) text += line.substr(0, columns - 1) + "\n";
  replace(text, table.size() + 2);
}

void Display::conclude(const RunFigures& figures) {
  std::string text = "\n";
  for (const std::string& line : format_table(figures)) text += line + "\n";
  replace(text + "\n" + format_summary(figures), 0);
}

}  // namespace sft::demo
