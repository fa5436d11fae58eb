#include "tools/demo/screen/display.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "tools/demo/screen/report.h"
#include "tools/terminal/columns.h"

namespace sft::demo {

/// The terminal would wrap longer lines, which could not be replaced then.
std::size_t Display::columns_shown() const { return std::min(terminal_.columns() - 1, columns_max); }

std::string Display::table(const RunFigures& figures, std::size_t columns) const {
  std::string text;
  for (const std::string& line : format_table(figures)) {
    text += terminal_.colored(line.substr(0, columns), text.empty() ? tool::Color::bold : tool::Color::none) +
            "\n";
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
  for (const std::string& line : tool::lines_of(text, columns_max, tool::LongWords::whole))
    lines += line + "\n";
  replace(lines, 0);
}

void Display::waiting(std::string_view what, Clock::time_point now) {
  const bool is_new = what != waits_for_;
  if (!is_new && now - said_at_ < std::chrono::seconds(1)) return;
  if (is_new) {
    waits_for_ = what;
    waits_since_ = now;
  }
  said_at_ = now;
  std::string line = waits_for_ + " ...";
  if (!is_new)
    line += fmt::format(" {} s", std::chrono::floor<std::chrono::seconds>(now - waits_since_).count());
  terminal_.on_terminal() ? replace(tool::shortened(line, columns_shown()) + "\n", 1) : say(line);
}

void Display::show(const RunFigures& figures, double elapsed_s) {
  if (!terminal_.on_terminal()) {
    if (elapsed_s < next_progress_s_) return;
    next_progress_s_ = std::floor(elapsed_s) + 1;
    say(format_progress(figures, elapsed_s));
    return;
  }
  const std::size_t columns = columns_shown();
  const std::string progress = format_progress(figures, elapsed_s).substr(0, columns);
  replace("\n" + table(figures, columns) + "\n" + progress + "\n", figures.subscribers.size() + 4);
}

void Display::conclude(const RunFigures& figures) {
  std::string text = "\n" + table(figures, columns_max) + "\n";
  const std::vector<std::string> summary = format_summary(figures);
  text += terminal_.colored(terminal_.colored(summary.front(), tool::Color::green), tool::Color::bold) + "\n";
  for (std::size_t i = 1; i < summary.size(); ++i) text += summary[i] + "\n";
  replace(text, 0);
}

}  // namespace sft::demo
