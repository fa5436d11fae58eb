// Passes items of several threads on to one receiver: in their order, one at a time, and without a lock held.
#pragma once

#include <utility>
#include <vector>

#include "core/sync/mutex.h"

namespace sft::core {

template <class Item>
class OrderedDelivery {
 public:
  /// All calls hold the same mutex, which gives items their order. `give(item)` is called without the lock:
  /// on this thread, or on another one that is delivering at that moment, which then delivers these items,
  /// too. The lock is held again when this returns. Clang does not follow a lock through a reference, so it
  /// does not check this function.
  template <class Give>
  void deliver(Lock& lock, std::vector<Item> items, Give give) SFT_NO_THREAD_SAFETY_ANALYSIS {
    for (Item& item : items) queue_.push_back(std::move(item));
    if (delivering_) return;
    delivering_ = true;
    while (!queue_.empty()) {
      const std::vector<Item> batch = std::exchange(queue_, {});
      lock.unlock();
      for (const Item& item : batch) give(item);
      lock.lock();
    }
    delivering_ = false;
  }

 private:
  // The mutex of the callers guards both.
  std::vector<Item> queue_;
  bool delivering_ = false;
};

}  // namespace sft::core
