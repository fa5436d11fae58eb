// A value that one thread replaces now and then and another reads all the time: reading an unchanged value is
// one atomic load. One reading thread at a time. Accesses are sequentially consistent, so that a reader may
// raise a flag before it loads, and a writer look for the flag after it stored.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <utility>

namespace sft::core {

template <class T>
class Snapshot {
 public:
  /// Any thread.
  void store(std::shared_ptr<const T> value) {
    const std::scoped_lock lock(mutex_);
    latest_.swap(value);
    version_.fetch_add(1, std::memory_order_seq_cst);
  }  // the value replaced dies after the lock is released

  /// The reading thread. Valid until its next load().
  const T* load() {
    if (version_.load(std::memory_order_seq_cst) != seen_) refresh();
    return in_use_.get();
  }

  /// The reading thread: what load() returned last, to be kept beyond the next one.
  const std::shared_ptr<const T>& loaded() const { return in_use_; }

  /// Any thread.
  std::shared_ptr<const T> share() const {
    const std::scoped_lock lock(mutex_);
    return latest_;
  }

 private:
  void refresh() {
    std::shared_ptr<const T> fresh;
    {
      const std::scoped_lock lock(mutex_);
      fresh = latest_;
      seen_ = version_.load(std::memory_order_relaxed);
    }
    in_use_.swap(fresh);
  }

  mutable std::mutex mutex_;
  std::shared_ptr<const T> latest_;
  std::atomic<std::uint64_t> version_{0};
  std::shared_ptr<const T> in_use_;  // the reading thread's
  std::uint64_t seen_ = 0;
};

}  // namespace sft::core
