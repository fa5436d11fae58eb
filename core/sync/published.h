// A value that some threads replace now and then, and that another thread reads frequently and without a
// lock. Reading an unchanged value takes one atomic load. Only one thread at a time may read.
//
// A thread that has replaced the value may wait until the reading thread no longer uses a former value. For
// this purpose the reading thread reads within a Reading, which begins before the value is loaded. The
// other thread replaces the value, and then checks for a Reading. These accesses are sequentially
// consistent, so that at least one of the threads sees the action of the other. So if the replacing thread
// does not see a Reading, this Reading loads the new value.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <utility>

#include "core/sync/backoff.h"
#include "core/sync/lock_order.h"
#include "core/sync/mutex.h"

namespace sft::core {

template <class T>
class Published {
 public:
  // The functions for any thread.

  void replace(std::shared_ptr<const T> value) {
    const Lock lock(mutex_);
    latest_.swap(value);
    version_.fetch_add(1, std::memory_order_seq_cst);
  }  // the former value is destroyed after the lock is released

  /// Waits until no Reading uses a value that was replaced before this call. The function waits for the
  /// present Reading, if there is one, but not for later ones. So it returns even if the reading thread
  /// reads all the time. Must not be called within a Reading.
  void wait_for_reader() const {
    const std::uint64_t seen = steps_.load(std::memory_order_seq_cst);
    if (seen % 2 == 0) return;
    wait_until([&] { return steps_.load(std::memory_order_acquire) != seen; });
  }

  std::shared_ptr<const T> share() const {
    const Lock lock(mutex_);
    return latest_;
  }

  // The functions for the reading thread.

  /// Marks the values that load() returns as in use, from here to the end of the scope.
  class Reading {
   public:
    explicit Reading(Published& published)
        : published_(published),
          is_only_(published.steps_.fetch_add(1, std::memory_order_seq_cst) % 2 == 0) {}
    ~Reading() {
      published_.steps_.store(published_.steps_.load(std::memory_order_relaxed) + 1,
                              std::memory_order_release);
    }
    Reading(const Reading&) = delete;
    Reading& operator=(const Reading&) = delete;
    /// Returns false if another Reading existed when this one began. Then two threads read at the same
    /// time, and load() must not be called.
    bool is_only() const { return is_only_; }

   private:
    Published& published_;
    const bool is_only_;
  };

  /// Returns the latest value, which lives until the next load(). It must be called within a Reading if any
  /// thread calls wait_for_reader().
  const T* load() {
    if (version_.load(std::memory_order_seq_cst) != seen_) refresh();
    return in_use_.get();
  }

  /// Returns the value that load() returned last, as a pointer that keeps the value alive beyond the next
  /// load().
  const std::shared_ptr<const T>& loaded() const { return in_use_; }

 private:
  void refresh() {
    std::shared_ptr<const T> fresh;
    {
      const Lock lock(mutex_);
      fresh = latest_;
      seen_ = version_.load(std::memory_order_relaxed);
    }
    in_use_.swap(fresh);
  }

  mutable Mutex mutex_ SFT_ACQUIRED_AFTER(lock_order::queues) SFT_ACQUIRED_BEFORE(lock_order::facts);
  std::shared_ptr<const T> latest_ SFT_GUARDED_BY(mutex_);
  std::atomic<std::uint64_t> version_{0};
  std::shared_ptr<const T> in_use_;  // used by the reading thread only
  std::uint64_t seen_ = 0;
  std::atomic<std::uint64_t> steps_{0};  ///< an odd number within a Reading
};

}  // namespace sft::core
