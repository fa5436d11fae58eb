// Decides when delivery to readers with full inboxes is retried: soon while they take samples, and less and
// less often while they do not. The class uses no clock, thread or I/O.
#pragma once

#include <algorithm>
#include <chrono>

namespace sft::udp {

class LagMonitor {
 public:
  using Time = std::chrono::steady_clock::time_point;
  static constexpr std::chrono::milliseconds soon{1};
  static constexpr std::chrono::milliseconds longest{16};

  /// Notes that the inbox of some reader is full.
  void begin(Time now) {
    if (look_at_ == Time::max()) look_at_ = now + pause_;
  }
  /// Notes the result of a retry: whether readers have taken samples, and whether samples still wait.
  void looked(Time now, bool some_was_taken, bool some_is_left) {
    pause_ = some_was_taken || !some_is_left ? soon : std::min(2 * pause_, longest);
    look_at_ = some_is_left ? now + pause_ : Time::max();
  }
  Time next_look() const { return look_at_; }

 private:
  std::chrono::milliseconds pause_ = soon;
  Time look_at_ = Time::max();
};

}  // namespace sft::udp
