#include "tools/demo/display.h"

#include <algorithm>
#include <cstdio>

#include "tools/terminal/columns.h"

namespace sft::demo {

/// Ends the line of the status, so that an error is printed on its own line.
Display::~Display() {
  if (terminal_.on_terminal() && !status_.empty()) std::puts("");
}

void Display::print(const std::string& lines) {
  if (terminal_.on_terminal()) std::fputs("\r\x1b[K", stdout);  // clears the line of the status
  std::fputs(lines.c_str(), stdout);
  std::fflush(stdout);
  status_.clear();
}

void Display::say(const std::string& text) {
  std::string lines;
  for (const std::string& line : tool::lines_of(text, columns_max, tool::LongWords::whole))
    lines += line + "\n";
  print(lines);
}

void Display::status(const std::string& text) {
  if (text == status_) return;
  // The terminal would wrap a longer line, which could not be cleared then.
  const std::size_t columns = std::min(terminal_.columns() - 1, columns_max);
  terminal_.on_terminal() ? print(tool::shortened(text, columns)) : say(text);
  status_ = text;
}

void Display::conclude(const RunFigures& run) {
  const std::vector<std::string> table = format_table(run), summary = format_summary(run);
  std::string text = "\n" + terminal_.colored(table.front(), tool::Color::bold) + "\n";
  for (std::size_t i = 1; i < table.size(); ++i) text += table[i] + "\n";
  text += "\n" + terminal_.colored(terminal_.colored(summary.front(), tool::Color::green), tool::Color::bold);
  for (std::size_t i = 1; i < summary.size(); ++i) text += "\n" + summary[i];
  print(text + "\n");
}

}  // namespace sft::demo
