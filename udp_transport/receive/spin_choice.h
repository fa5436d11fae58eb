// Decides whether to look for the next datagram with a busy core before sleeping. Pure.
#pragma once

#include <atomic>
#include <chrono>
#include <set>

#include "core/sync/mutex.h"

namespace sft::udp {

/// Spinning pays as long as samples come about as fast as a thread can be woken. A program that answers at
/// once and gets the next sample for it is quicker from then on, and samples that come now and then cost
/// nothing.
class SpinChoice {
 public:
  using Duration = std::chrono::nanoseconds;

  Duration choose(Duration limit) const { return last_wait_ / worth_while <= limit ? limit : Duration{0}; }
  /// Tells how long the next sample did not come.
  void waited(Duration time) { last_wait_ = time; }

 private:
  static constexpr int worth_while = 3;
  Duration last_wait_ = Duration::max();
};

/// The limits on spinning that the readers of a transport set. Any thread.
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
