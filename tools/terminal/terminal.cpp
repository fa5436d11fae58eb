#include "tools/terminal/terminal.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdlib>

#include "tools/terminal/columns.h"

namespace sft::tool {

namespace {

winsize terminal_size() {
  winsize size{};
  ioctl(STDOUT_FILENO, TIOCGWINSZ, &size);
  return size;
}

}  // namespace

Terminal::Terminal(bool no_color) : terminal_(isatty(STDOUT_FILENO) != 0) {
  const char* unwanted = std::getenv("NO_COLOR");
  colors_ = terminal_ && !no_color && (unwanted == nullptr || *unwanted == '\0');
}

std::size_t Terminal::columns() const {
  const std::size_t columns = terminal_ ? terminal_size().ws_col : 0;
  return columns == 0 ? 80 : columns;
}

std::size_t Terminal::rows() const {
  const std::size_t rows = terminal_ ? terminal_size().ws_row : 0;
  return rows == 0 ? 24 : rows;
}

std::string Terminal::colored(std::string_view text, Color color) const {
  if (!colors_ || color == Color::none) return std::string(text);
  return "\x1b[" + std::to_string(static_cast<int>(color)) + "m" + std::string(text) + "\x1b[0m";
}

std::string Terminal::fitted(std::string_view text, std::size_t indent, std::size_t before) const {
  return terminal_ ? wrapped(text, columns(), indent, before) : std::string(text);
}

}  // namespace sft::tool
