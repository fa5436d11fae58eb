// Ctrl-C, as something that can be waited for. The signals that end a program only raise a flag from here on,
// so that every command says goodbye to other nodes.
#pragma once

#include <chrono>

namespace sft::tool {

class Stop {
 public:
  /// Before the program has threads, which inherit what is blocked.
  Stop();
  ~Stop();
  Stop(const Stop&) = delete;
  Stop& operator=(const Stop&) = delete;

  /// The user wants to stop, or nobody reads the output any more.
  bool requested() const;
  void request();
  /// Until somebody wants to stop, which it tells, or the time is over. Ends sooner, with false, when
  /// `descriptor` is readable.
  bool wait_for(std::chrono::nanoseconds time, int descriptor = -1);

 private:
  void look();

  int signals_ = -1;
  bool requested_ = false;
};

}  // namespace sft::tool
