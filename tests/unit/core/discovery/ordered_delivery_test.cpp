#include "core/discovery/ordered_delivery.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

namespace sft::core {
namespace {

TEST(OrderedDelivery, GivesItemsOfAllThreadsOneAtATimeInTheirOrder) {
  constexpr int threads = 4, items_each = 2000;
  std::mutex mutex;
  OrderedDelivery<int> delivery;
  int next = 0;                // under the mutex
  std::vector<int> delivered;  // by one thread at a time
  std::atomic<int> inside{0};
  std::atomic<bool> overlapped{false};
  const auto work = [&] {
    for (int i = 0; i < items_each; ++i) {
      delivery.deliver(
          mutex, [&] { return std::vector<int>{next++}; },
          [&](int item) {
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
  std::mutex mutex;
  OrderedDelivery<int> delivery;
  std::vector<int> delivered;
  const auto give = [&](int item) {
    ASSERT_TRUE(mutex.try_lock());
    mutex.unlock();
    delivered.push_back(item);
  };
  delivery.deliver(
      mutex,
      [] {
        return std::vector<int>{1, 2};
      },
      [&](int item) {
        give(item);  // and the receiver may cause more
        if (item == 1)
          delivery.deliver(
              mutex, [] { return std::vector<int>{3}; }, give);
      });
  EXPECT_EQ(delivered, (std::vector<int>{1, 2, 3}));
}

}  // namespace
}  // namespace sft::core
