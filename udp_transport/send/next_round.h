// The time of the sending thread's next round of sending. The thread sleeps until then. Uses no clock,
// thread or I/O.
#pragma once

#include <algorithm>
#include <chrono>

namespace sft::udp {

class NextRound {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// Begins a round. The next round is not scheduled yet.
  void begin() { time_ = Time::max(); }
  void at_once() { time_ = {}; }
  void by(Time time) { time_ = std::min(time_, time); }
  Time time() const { return time_; }

 private:
  Time time_ = Time::max();
};

}  // namespace sft::udp
