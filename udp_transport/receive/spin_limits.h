// The maximum times of spinning (polling before a thread sleeps) that the readers of a transport set. Any
// thread may call the functions.
#pragma once

#include <atomic>
#include <chrono>
#include <set>

#include "core/sync/mutex.h"

namespace sft::udp {

class SpinLimits {
 public:
  using Duration = std::chrono::nanoseconds;

  void add(Duration limit) {
    const core::Lock lock(mutex_);
    all_.insert(limit);
    note();
  }
  void remove(Duration limit) {
    const core::Lock lock(mutex_);
    all_.erase(all_.find(limit));
    note();
  }
  Duration largest() const { return largest_.load(std::memory_order_relaxed); }

 private:
  void note() SFT_REQUIRES(mutex_) {
    largest_.store(all_.empty() ? Duration{0} : *all_.rbegin(), std::memory_order_relaxed);
  }

  core::Mutex mutex_;
  std::multiset<Duration> all_ SFT_GUARDED_BY(mutex_);
  std::atomic<Duration> largest_{Duration{0}};
};

}  // namespace sft::udp
