#include "tools/sft/screen.h"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>

#include "tools/terminal/columns.h"

namespace sft::tool {

Screen::Screen(Output& output) : output_(output) {
  if (isatty(STDIN_FILENO) != 0 && tcgetattr(STDIN_FILENO, &before_) == 0) {
    keys_ = STDIN_FILENO;
    termios raw = before_;
    raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
    raw.c_cc[VSUSP] = _POSIX_VDISABLE;  // disables Ctrl-Z, which would leave the terminal in this state
    tcsetattr(keys_, TCSANOW, &raw);
  }
  output_.write("\x1b[?1049h\x1b[?25l");  // the alternative screen, without a cursor
}

Screen::~Screen() {
  output_.write("\x1b[?25h\x1b[?1049l");
  if (keys_ >= 0) tcsetattr(keys_, TCSANOW, &before_);
}

void Screen::show(const std::vector<Line>& lines) {
  std::string page = "\x1b[H";
  const std::size_t rows = std::min(lines.size(), output_.rows());
  for (std::size_t i = 0; i < rows; ++i) {
    page += output_.colored(std::string(cut(lines[i].text, output_.columns())), lines[i].color) + "\x1b[K";
    if (i + 1 < rows) page += "\r\n";
  }
  output_.write(page + "\x1b[J");
}

bool Screen::pressed(char key) const {
  bool found = false;
  pollfd input{keys_, POLLIN, 0};
  while (keys_ >= 0 && poll(&input, 1, 0) > 0) {
    std::array<char, 64> typed{};
    const ssize_t bytes = read(keys_, typed.data(), typed.size());
    if (bytes <= 0) return true;  // the terminal has been closed
    found |= std::find(typed.begin(), typed.begin() + bytes, key) != typed.begin() + bytes;
  }
  return found;
}

}  // namespace sft::tool
