// Chooses whether a wait for a sample spins before it sleeps: only if the wait before it was short. Spinning
// that does not see the sample costs its whole time, and lets the thread fall asleep no later.
#pragma once

#include <atomic>
#include <chrono>

namespace sft::core {

class SpinChoice {
 public:
  using Duration = std::chrono::nanoseconds;

  /// `spin`: how long a wait spins if it does.
  explicit SpinChoice(Duration spin) : spin_(spin) {}

  /// Returns how long the wait that begins now spins. Any thread.
  Duration spin() const { return pays_.load(std::memory_order_relaxed) ? spin_ : Duration{0}; }

  /// A wait has ended, with a sample or at its deadline. Any thread.
  void waited(Duration how_long, bool found) {
    if (found) {
      pays_.store(how_long / short_wait <= spin_, std::memory_order_relaxed);
    } else if (how_long >= spin_) {
      pays_.store(false, std::memory_order_relaxed);
    }
  }

 private:
  // A wait of at most so many times the spin is short. Two programs that answer each other, and sleep
  // meanwhile, wait for two threads to be woken on two hosts. They have to find out that spinning would spare
  // them that.
  static constexpr int short_wait = 10;

  const Duration spin_;
  std::atomic<bool> pays_{true};
};

}  // namespace sft::core
