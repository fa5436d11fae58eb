// A count of events that threads can wait to see grow: whoever looks at something that events change first
// reads the count, and then waits for one beyond it, misses none.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>

namespace sft::core {

class EventCount {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  void raise() {
    {
      const std::scoped_lock lock(mutex_);
      ++count_;
    }
    raised_.notify_all();
  }

  std::uint64_t value() const {
    const std::scoped_lock lock(mutex_);
    return count_;
  }

  /// Waits until the count is beyond `seen`. Returns false if it is not at the deadline.
  bool wait_beyond(std::uint64_t seen, TimePoint deadline) {
    std::unique_lock lock(mutex_);
    return raised_.wait_until(lock, deadline, [&] { return count_ > seen; });
  }

 private:
  mutable std::mutex mutex_;
  std::condition_variable raised_;
  std::uint64_t count_ = 0;
};

}  // namespace sft::core
