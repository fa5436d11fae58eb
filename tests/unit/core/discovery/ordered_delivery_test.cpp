#include "core/discovery/ordered_delivery.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

namespace sft::core {
namespace {

TEST(OrderedDelivery, GivesItemsOfAllThreadsOneAtATimeInTheirOrder) {
  constexpr int threads = 4, items_each = 2000;
  Mutex mutex;
  OrderedDelivery<int> delivery;
  int next = 0;                // protected by the mutex
  std::vector<int> delivered;  // used by one thread at a time
  std::atomic<int> inside{0};
  std::atomic<bool> overlapped{false};
  const auto work = [&] {
    for (int i = 0; i < items_each; ++i) {
      Lock lock(mutex);
      delivery.deliver(lock, {next++}, [&](int item) {
        if (inside.fetch_add(1) != 0) overlapped = true;
        delivered.push_back(item);
        inside.fetch_sub(1);
      });
    }
  };
  std::vector<std::thread> workers;
  for (int i = 0; i < threads; ++i) workers.emplace_back(work);
  for (std::thread& worker : workers) worker.join();
  EXPECT_FALSE(overlapped);
  ASSERT_EQ(delivered.size(), static_cast<std::size_t>(threads * items_each));
  for (int i = 0; i < threads * items_each; ++i) ASSERT_EQ(delivered[static_cast<std::size_t>(i)], i);
}

TEST(OrderedDelivery, HoldsNoLockWhileItGives) {
  Mutex mutex;
  OrderedDelivery<int> delivery;
  std::vector<int> delivered;
  const auto give = [&](int item) {
    const bool is_free = mutex.try_lock();
    if (is_free) mutex.unlock();
    EXPECT_TRUE(is_free);
    delivered.push_back(item);
  };
  Lock lock(mutex);
  delivery.deliver(lock, {1, 2}, [&](int item) {
    give(item);
    if (item != 1) return;
    Lock again(mutex);  // the receiver may add further items
    delivery.deliver(again, {3}, give);
  });
  EXPECT_EQ(delivered, (std::vector<int>{1, 2, 3}));
}

}  // namespace
}  // namespace sft::core
