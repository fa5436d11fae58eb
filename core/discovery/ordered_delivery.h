// Passes items of several threads on to one receiver: in their order, one at a time, and without a lock held.
#pragma once

#include <mutex>
#include <utility>
#include <vector>

namespace sft::core {

template <class Item>
class OrderedDelivery {
 public:
  /// `take()` returns items; it is called under `mutex`, which gives them their order. `give(item)` is called
  /// on this thread, or on another one that is giving items at that moment and then gives these, too.
  template <class Take, class Give>
  void deliver(std::mutex& mutex, Take take, Give give) {
    std::unique_lock lock(mutex);
    for (Item& item : take()) queue_.push_back(std::move(item));
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
  std::vector<Item> queue_;
  bool delivering_ = false;
};

}  // namespace sft::core
