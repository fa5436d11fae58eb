// Reads the keys that a user presses while a command runs. Without a terminal, no key is ever pressed.
#pragma once

#include <termios.h>

namespace sft::tool {

/// Makes the terminal deliver each key at once and without an echo. The destructor restores the former
/// settings.
class Keys {
 public:
  Keys();
  ~Keys();
  Keys(const Keys&) = delete;
  Keys& operator=(const Keys&) = delete;

  /// The descriptor from which keys are read; -1: the standard input is no terminal.
  int descriptor() const { return descriptor_; }
  /// Returns true if the user has pressed this key. Discards all other keys.
  bool pressed(char key) const;

 private:
  int descriptor_ = -1;
  termios before_{};
};

}  // namespace sft::tool
