// Ctrl-C, as something that can be waited for. From the construction of a Stop on the signals that end a
// program only raise a flag, so that the program can say goodbye to other nodes.
#pragma once

#include <chrono>

namespace sft::tool {

class Stop {
 public:
  /// REQUIRES: the program has no other thread yet, since threads inherit which signals are blocked.
  Stop();
  ~Stop();
  Stop(const Stop&) = delete;
  Stop& operator=(const Stop&) = delete;

  /// True if the user wants to stop, or if nobody reads the output any more.
  bool requested() const;
  void request();
  /// Forgets the request, so that the next one can be waited for.
  void forget() { requested_ = false; }
  /// Waits until somebody wants to stop, which is true, or until the time is over. Ends sooner, with false,
  /// when `descriptor` is readable.
  bool wait_for(std::chrono::nanoseconds time, int descriptor = -1);

 private:
  void look();

  int signals_ = -1;
  bool requested_ = false;
};

}  // namespace sft::tool
