// Chooses whether a wait for samples spins before it sleeps: only if the wait before it was short. Spinning
// that does not see the sample costs its whole time, and lets the thread fall asleep no later.
#pragma once

#include <atomic>
#include <chrono>

namespace sft::core {

class SpinChoice {
 public:
  using Duration = std::chrono::nanoseconds;

  /// A wait of at most `short_wait` times the limit on spinning is short.
  explicit SpinChoice(int short_wait) : short_wait_(short_wait) {}

  /// Returns how long the wait that begins now spins: `limit`, or not at all. The first wait spins. Any
  /// thread.
  Duration spin(Duration limit) const {
    return last_wait_.load(std::memory_order_relaxed) / short_wait_ <= limit ? limit : Duration{0};
  }

  /// A wait has ended that was allowed to spin for `limit`, with a sample or without one. Any thread.
  void waited(Duration how_long, bool found, Duration limit) {
    if (!found && how_long < limit) return;  // the wait ended before the spinning did
    last_wait_.store(found ? how_long : Duration::max(), std::memory_order_relaxed);
  }

 private:
  const int short_wait_;
  std::atomic<Duration> last_wait_{Duration{0}};
};

}  // namespace sft::core
