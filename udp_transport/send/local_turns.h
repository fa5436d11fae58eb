// Makes the sending thread yield to publishers and their readers on this host. That thread can be busy for
// milliseconds with a sample for other hosts. A scheduler may let it go on for that long while the thread
// that publishes, or a reader that was woken, waits for a processor.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <utility>

namespace sft::udp {

class LocalTurns {
 public:
  using Time = std::chrono::steady_clock::time_point;
  /// The time from when the sending thread sees that a turn is over. Readers are woken by another thread of
  /// their process, one after another.
  static constexpr std::chrono::milliseconds time_to_wake{1};

  // Publishers call these when they begin and end publishing a sample to readers on this host. Any thread.

  void begin() noexcept { state_.fetch_add(one_under_way, std::memory_order_relaxed); }
  void end() noexcept { state_.fetch_add(one_over - one_under_way, std::memory_order_relaxed); }

  // The sending thread.

  /// Returns true while there is such a turn, and for a moment after it, when its readers wake up.
  bool is_due(Time now) noexcept {
    const std::uint64_t state = state_.load(std::memory_order_relaxed);
    const auto over = static_cast<std::uint32_t>(state >> 32);
    const bool is_under_way = static_cast<std::uint32_t>(state) != 0;
    if (std::exchange(over_, over) != over || is_under_way) until_ = now + time_to_wake;
    return now < until_;
  }

 private:
  static constexpr std::uint64_t one_under_way = 1, one_over = std::uint64_t{1} << 32;

  /// The number of turns under way in the lower half, and of finished turns in the upper half.
  std::atomic<std::uint64_t> state_{0};
  /// Number of finished turns when seen last; on a cache line of its own.
  alignas(64) std::uint32_t over_ = 0;
  Time until_{};
};

}  // namespace sft::udp
