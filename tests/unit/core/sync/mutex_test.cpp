// Mutexes, their locks, and waiting for a condition. Accesses without a lock are checked by Clang when it
// compiles the project.
#include "core/sync/mutex.h"

#include <gtest/gtest.h>

#include <thread>

namespace sft::core {
namespace {

using namespace std::chrono_literals;

/// Returns true if another thread can lock the mutex at present.
bool is_free(Mutex& mutex) {
  bool locked = false;
  std::thread other([&] {
    if (!mutex.try_lock()) return;
    locked = true;
    mutex.unlock();
  });
  other.join();
  return locked;
}

TEST(MutexTest, ALockHoldsTheMutexUntilTheEndOfTheScope) {
  Mutex mutex;
  {
    const Lock lock(mutex);
    EXPECT_FALSE(is_free(mutex));
  }
  EXPECT_TRUE(is_free(mutex));
}

TEST(MutexTest, ALockCanBeUnlockedAndLockedAgain) {
  Mutex mutex;
  Lock lock(mutex);
  lock.unlock();
  EXPECT_TRUE(is_free(mutex));
  lock.lock();
  EXPECT_FALSE(is_free(mutex));
}

TEST(MutexTest, AnUnlockedLockLeavesTheMutexAloneAtTheEndOfTheScope) {
  Mutex mutex;
  {
    Lock lock(mutex);
    lock.unlock();
  }
  EXPECT_TRUE(is_free(mutex));
}

TEST(ConditionTest, AWaitTellsThatTheTimeIsOverAndHoldsTheMutexAgain) {
  Mutex mutex;
  Condition never;
  Lock lock(mutex);
  while (never.wait_for(lock, 1ms)) continue;
  while (never.wait_until(lock, std::chrono::steady_clock::now() + 1ms)) continue;
  EXPECT_FALSE(is_free(mutex));
}

/// A number that one thread increments while another thread waits until it has a certain value.
class Count {
 public:
  void raise() {
    {
      const Lock lock(mutex_);
      ++count_;
    }
    raised_.notify_one();
  }
  bool reaches(int count, std::chrono::nanoseconds hang_timeout) {
    const auto deadline = std::chrono::steady_clock::now() + hang_timeout;
    Lock lock(mutex_);
    while (count_ < count && raised_.wait_until(lock, deadline)) continue;
    return count_ >= count;
  }
  void await(int count) {
    Lock lock(mutex_);
    while (count_ < count) raised_.wait(lock);
  }

 private:
  Mutex mutex_;
  Condition raised_;
  int count_ SFT_GUARDED_BY(mutex_) = 0;
};

TEST(ConditionTest, AWaitingThreadIsWokenByAnother) {
  Count count;
  std::thread other([&] {
    for (int i = 0; i < 1000; ++i) count.raise();
  });
  count.await(1);
  EXPECT_TRUE(count.reaches(1000, 10s));
  EXPECT_FALSE(count.reaches(1001, 1ms));
  other.join();
}

}  // namespace
}  // namespace sft::core
