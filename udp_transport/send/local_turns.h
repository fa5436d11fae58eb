// Makes the sending thread yield to publishers and their readers on this host. The sending thread can be
// busy for milliseconds with a sample for other hosts. Meanwhile the scheduler might not run the publishing
// thread, or a reader that was woken.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <utility>

namespace sft::udp {

class LocalTurns {
 public:
  using Time = std::chrono::steady_clock::time_point;
  /// The time that readers get to wake up, after the sending thread has noticed the end of publishing. A
  /// thread of their process wakes them one after another.
  static constexpr std::chrono::milliseconds time_to_wake{1};

  // Publishers call these two functions when they begin and end publishing a sample to readers on this host.
  // Any thread may call them.

  void begin() noexcept { state_.fetch_add(one_under_way, std::memory_order_relaxed); }
  void end() noexcept { state_.fetch_add(one_over - one_under_way, std::memory_order_relaxed); }

  // The following functions are for the sending thread.

  /// Returns true while a publisher publishes to readers on this host, and for `time_to_wake` after that.
  bool is_due(Time now) noexcept {
    const std::uint64_t state = state_.load(std::memory_order_relaxed);
    const auto over = static_cast<std::uint32_t>(state >> 32);
    const bool is_under_way = static_cast<std::uint32_t>(state) != 0;
    if (std::exchange(over_, over) != over || is_under_way) until_ = now + time_to_wake;
    return now < until_;
  }

 private:
  static constexpr std::uint64_t one_under_way = 1, one_over = std::uint64_t{1} << 32;

  /// The lower half is the number of publishers that publish to this host now. The upper half is the number
  /// of times that one has finished.
  std::atomic<std::uint64_t> state_{0};
  /// The upper half of `state_` at the last check. It has its own cache line.
  alignas(64) std::uint32_t over_ = 0;
  Time until_{};
};

}  // namespace sft::udp
