// A mutex, its lock, and a condition variable: the classes of the standard library, with the attributes by
// which Clang checks the locks that are held (thread_annotations.h).
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>

#include "core/sync/thread_annotations.h"

namespace sft::core {

class SFT_CAPABILITY("mutex") Mutex {
 public:
  Mutex() = default;
  Mutex(const Mutex&) = delete;
  Mutex& operator=(const Mutex&) = delete;

  void lock() SFT_ACQUIRE() { mutex_.lock(); }
  void unlock() SFT_RELEASE() { mutex_.unlock(); }
  bool try_lock() SFT_TRY_ACQUIRE(true) { return mutex_.try_lock(); }

 private:
  friend class Lock;
  std::mutex mutex_;
};

/// Holds a mutex until the end of the scope. The mutex may be unlocked and locked again before the end.
class SFT_SCOPED_CAPABILITY Lock {
 public:
  explicit Lock(Mutex& mutex) SFT_ACQUIRE(mutex) : lock_(mutex.mutex_) {}
  ~Lock() SFT_RELEASE() = default;
  Lock(const Lock&) = delete;
  Lock& operator=(const Lock&) = delete;

  void lock() SFT_ACQUIRE() { lock_.lock(); }
  void unlock() SFT_RELEASE() { lock_.unlock(); }

 private:
  friend class Condition;
  std::unique_lock<std::mutex> lock_;
};

/// A condition variable. A wait unlocks the lock, and locks it again before it returns. A wait may also end
/// spuriously, so callers must wait in a loop. There are no functions that take a predicate, because Clang
/// does not know that the predicate is called with the lock held.
class Condition {
 public:
  void wait(Lock& lock) { condition_.wait(lock.lock_); }

  /// Waits for at most `time`. Returns false if `time` has passed.
  template <class Rep, class Period>
  bool wait_for(Lock& lock, const std::chrono::duration<Rep, Period>& time) {
    return condition_.wait_for(lock.lock_, time) == std::cv_status::no_timeout;
  }
  template <class Clock, class Duration>
  bool wait_until(Lock& lock, const std::chrono::time_point<Clock, Duration>& time) {
    return condition_.wait_until(lock.lock_, time) == std::cv_status::no_timeout;
  }

  void notify_one() noexcept { condition_.notify_one(); }
  void notify_all() noexcept { condition_.notify_all(); }

 private:
  std::condition_variable condition_;
};

}  // namespace sft::core
