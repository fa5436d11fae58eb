// A count of events. Threads can wait until it grows. A thread misses no event if it first reads the count,
// then examines the state that events change, and then waits for a greater count.
#pragma once

#include <chrono>
#include <cstdint>

#include "core/sync/mutex.h"

namespace sft::core {

class EventCount {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  void raise() {
    {
      const Lock lock(mutex_);
      ++count_;
    }
    raised_.notify_all();
  }

  std::uint64_t value() const {
    const Lock lock(mutex_);
    return count_;
  }

  /// Waits until the count is greater than `seen`. Returns false if the deadline has passed without that.
  bool wait_beyond(std::uint64_t seen, TimePoint deadline) {
    Lock lock(mutex_);
    while (count_ <= seen) {
      if (!raised_.wait_until(lock, deadline)) return count_ > seen;
    }
    return true;
  }

 private:
  mutable Mutex mutex_;
  Condition raised_;
  std::uint64_t count_ SFT_GUARDED_BY(mutex_) = 0;
};

}  // namespace sft::core
