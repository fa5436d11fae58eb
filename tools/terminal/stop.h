// Lets a program wait for Ctrl-C. Once a Stop is constructed, the signals that end a program only set a flag,
// so that the program can close its node in order.
#pragma once

#include <chrono>

namespace sft::tool {

class Stop {
 public:
  /// Blocks these signals. REQUIRES: the program has no other thread yet, since new threads inherit the
  /// mask of blocked signals.
  Stop();
  ~Stop();
  Stop(const Stop&) = delete;
  Stop& operator=(const Stop&) = delete;

  /// Returns true if the user has requested a stop, or if the program that reads the output has closed it.
  bool requested() const;
  void request();
  /// Discards the present request, so that the program can wait for the next request.
  void forget() { requested_ = false; }
  /// Waits until a stop is requested, and returns true. Returns false when `time` is over, or when
  /// `descriptor` is readable.
  bool wait_for(std::chrono::nanoseconds time, int descriptor = -1);

 private:
  void look();

  int signals_ = -1;
  bool requested_ = false;
};

}  // namespace sft::tool
