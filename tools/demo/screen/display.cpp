#include "tools/demo/screen/display.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tools/demo/screen/report.h"
#include "tools/terminal/columns.h"
#include "tools/terminal/wrapped.h"

namespace sft::demo {

namespace {

/// The terminal would wrap longer lines, which could not be replaced then.
std::size_t columns_shown() {
  winsize size{};
  const bool known = ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1;
  return known ? std::min<std::size_t>(size.ws_col - 1, columns_max) : columns_max;
}

}  // namespace

Display::Display(bool colours_wanted)
    : terminal_(isatty(STDOUT_FILENO) != 0), colours_(terminal_ && colours_wanted) {}

std::string Display::painted(const std::string& line, Style style) const {
  if (!colours_ || style == Style::plain) return line;
  return fmt::format("\x1b[{}m{}\x1b[0m", style == Style::pitch ? "1;32" : "1", line);
}

std::string Display::painted_table(const RunFigures& figures, std::size_t columns) const {
  std::string text;
  Style style = Style::head;
  for (const std::string& line : format_table(figures)) {
    text += painted(line.substr(0, columns), style) + "\n";
    style = Style::plain;
  }
  return text;
}

void Display::replace(const std::string& lines, std::size_t count) {
  if (shown_lines_ > 0)
    std::printf("\x1b[%zuA\x1b[J", shown_lines_);  // moves up to the first line, and clears the rest
  std::fputs(lines.c_str(), stdout);
  std::fflush(stdout);
  shown_lines_ = count;
}

void Display::say(const std::string& text) {
  std::string lines;
  for (const std::string& line : tool::wrapped_lines(text, columns_max)) lines += line + "\n";
  replace(lines, 0);
}

void Display::waiting(std::string_view what, WaitNotice::Clock::time_point now) {
  const std::optional<std::string> line = notice_.line(what, now);
  if (!line) return;
  terminal_ ? replace(tool::shortened(*line, columns_shown()) + "\n", 1) : say(*line);
}

void Display::show(const RunFigures& figures, double elapsed_s) {
  if (!terminal_) {
    if (elapsed_s < next_progress_s_) return;
    next_progress_s_ = std::floor(elapsed_s) + 1;
    say(format_progress(figures, elapsed_s));
    return;
  }
  const std::size_t columns = columns_shown();
  const std::string progress = format_progress(figures, elapsed_s).substr(0, columns);
  replace("\n" + painted_table(figures, columns) + "\n" + progress + "\n", figures.subscribers.size() + 4);
}

void Display::conclude(const RunFigures& figures) {
  std::string text = "\n" + painted_table(figures, columns_max) + "\n";
  Style style = Style::pitch;
  for (const std::string& line : format_summary(figures)) {
    text += painted(line, style) + "\n";
    style = Style::plain;
  }
  replace(text, 0);
}

}  // namespace sft::demo
