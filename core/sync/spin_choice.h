// Decides whether a wait for samples spins before it sleeps. A wait spins only if the previous wait was
// short, because the time of the spinning is wasted if no sample arrives meanwhile.
#pragma once

#include <atomic>
#include <chrono>

namespace sft::core {

class SpinChoice {
 public:
  using Duration = std::chrono::nanoseconds;

  /// A wait is short if it lasts at most `short_wait` times as long as the limit on spinning.
  explicit SpinChoice(int short_wait) : short_wait_(short_wait) {}

  /// Returns the time for which the wait that begins now spins: `limit`, or 0. The first wait spins. Any
  /// thread may call this.
  Duration spin(Duration limit) const {
    return last_wait_.load(std::memory_order_relaxed) / short_wait_ <= limit ? limit : Duration{0};
  }

  /// Called when a wait that was allowed to spin for `limit` has ended after `how_long`. `found` is true if
  /// a sample has arrived. Any thread may call this.
  void waited(Duration how_long, bool found, Duration limit) {
    if (!found && how_long < limit) return;  // the wait was shorter than the spinning would have been
    last_wait_.store(found ? how_long : Duration::max(), std::memory_order_relaxed);
  }

 private:
  const int short_wait_;
  std::atomic<Duration> last_wait_{Duration{0}};
};

}  // namespace sft::core
