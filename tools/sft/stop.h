// Turns Ctrl-C and the other signals that end a program into a flag that can be waited for, so that every
// command closes its node and takes leave of other nodes.
#pragma once

#include <chrono>

namespace sft::tool {

class Stop {
 public:
  /// Blocks the signals. Must run before the program has threads, since threads inherit the blocked signals.
  Stop();
  ~Stop();
  Stop(const Stop&) = delete;
  Stop& operator=(const Stop&) = delete;

  /// True if the user wants to stop, or if the reader of the output has gone.
  bool requested() const;
  void request();
  /// Waits until the time is over. Returns true at once if a stop is requested, and false at once if
  /// `descriptor` is readable.
  bool wait_for(std::chrono::nanoseconds time, int descriptor = -1);

 private:
  void look();

  int signals_ = -1;
  bool requested_ = false;
};

}  // namespace sft::tool
