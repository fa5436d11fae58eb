#include "tools/sft/keys.h"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>

namespace sft::tool {

Keys::Keys() {
  // The system would stop a program in the background that changes its terminal.
  const pid_t foreground = tcgetpgrp(STDIN_FILENO);
  if (foreground >= 0 && foreground != getpgrp()) return;
  if (isatty(STDIN_FILENO) == 0 || tcgetattr(STDIN_FILENO, &before_) != 0) return;
  descriptor_ = STDIN_FILENO;
  termios raw = before_;
  raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
  raw.c_cc[VSUSP] = _POSIX_VDISABLE;  // Ctrl-Z would leave the terminal in this state
  tcsetattr(descriptor_, TCSANOW, &raw);
}

Keys::~Keys() {
  if (descriptor_ >= 0) tcsetattr(descriptor_, TCSANOW, &before_);
}

bool Keys::pressed(char key) const {
  bool found = false;
  pollfd input{descriptor_, POLLIN, 0};
  while (descriptor_ >= 0 && poll(&input, 1, 0) > 0) {
    std::array<char, 64> typed{};
    const ssize_t bytes = read(descriptor_, typed.data(), typed.size());
    if (bytes <= 0) return true;  // the terminal is gone
    found |= std::find(typed.begin(), typed.begin() + bytes, key) != typed.begin() + bytes;
  }
  return found;
}

}  // namespace sft::tool
