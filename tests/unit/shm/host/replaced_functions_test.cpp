// The functions of iceoryx that SFT replaces, called by many threads at once. The models in tests/model try
// all orders of the functions' steps.
#include "shm_transport/host/replaced_functions.h"

#include <dlfcn.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <numeric>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "shm_transport/host/iceoryx.h"
#include "tests/support/test_seed.h"

namespace sft::test {
namespace {

using FreeList = iox::concurrent::LoFFLi;
using Queue = iox::concurrent::ResizeableLockFreeQueue<std::uint64_t, shm::queue_places_max>;

TEST(ReplacedFunctions, AreTheOnesThatIceoryxCalls) { EXPECT_TRUE(shm::functions_are_replaced()); }

TEST(ReplacedFunctions, AreFoundFirstByTheDynamicLinker) {
  Dl_info ours{};
  ASSERT_NE(dladdr(reinterpret_cast<const void*>(&shm::functions_are_replaced), &ours), 0);
  for (const char* name :
       {"_ZN3iox10concurrent6LoFFLi3popERj", "_ZN3iox10concurrent6LoFFLi4pushEj",
        "_ZN3iox10concurrent10IndexQueueILm256EmE3popERm", "_ZN3iox10concurrent10IndexQueueILm256EmE4pushEm",
        "_ZN3iox10concurrent10IndexQueueILm256EmE18popIfSizeIsAtLeastEmRm"}) {
    Dl_info found{};
    ASSERT_NE(dladdr(dlsym(RTLD_DEFAULT, name), &found), 0) << name;
    EXPECT_EQ(found.dli_fbase, ours.dli_fbase) << name << " is that of " << found.dli_fname;
  }
}

/// A list of a few chunks that many threads take and give back.
class FreeListTest : public RandomTest {
 protected:
  static constexpr std::uint32_t chunks = 4;

  FreeListTest() { list_.init(next_.data(), chunks); }

  /// Takes a chunk and gives it back, `times` times. A thread that has taken a chunk must be its only owner.
  void take_and_give_back(std::uint64_t times, std::uint64_t seed) {
    Random dice(seed);
    const auto maybe_wait = [&dice] {
      if (dice() % 4 == 0) std::this_thread::yield();
    };
    for (; times > 0; --times) {
      std::uint32_t chunk = chunks;
      if (!list_.pop(chunk)) continue;
      if (owned_[chunk].exchange(true)) ++second_owners_;
      maybe_wait();
      owned_[chunk].store(false);
      if (!list_.push(chunk)) ++refused_;
      maybe_wait();
    }
  }

  std::array<std::uint32_t, chunks + 1> next_{};
  FreeList list_;
  std::array<std::atomic<bool>, chunks> owned_{};
  std::atomic<std::uint64_t> second_owners_{0}, refused_{0};
};

TEST_F(FreeListTest, LendsEachChunkToOneOwnerAndLosesNone) {
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < 6; ++i)
      threads.emplace_back([this, seed = random()] { take_and_give_back(test_rounds(2'000), seed); });
  }
  EXPECT_EQ(second_owners_, 0U);
  EXPECT_EQ(refused_, 0U);
  std::vector<std::uint32_t> free;
  for (std::uint32_t chunk = 0; list_.pop(chunk);) free.push_back(chunk);
  EXPECT_EQ((std::set<std::uint32_t>(free.begin(), free.end())), (std::set<std::uint32_t>{0, 1, 2, 3}));
  EXPECT_EQ(free.size(), chunks);
}

TEST_F(FreeListTest, LendsTheChunkThatWasGivenBackLastAndNoneTwice) {
  std::uint32_t first = chunks, second = chunks;
  ASSERT_TRUE(list_.pop(first) && list_.pop(second));
  EXPECT_NE(first, second);
  EXPECT_TRUE(list_.push(first));
  EXPECT_FALSE(list_.push(first)) << "it was given back before";
  EXPECT_FALSE(list_.push(chunks)) << "there is no such chunk";
  std::uint32_t again = chunks;
  EXPECT_TRUE(list_.pop(again));
  EXPECT_EQ(again, first);
}

class QueueTest : public RandomTest {
 protected:
  /// Returns the numbers that leave the queue while another thread pushes 0, 1, ... `push` returns the number
  /// that it displaced.
  template <class Push>
  std::vector<std::uint64_t> numbers_through(Queue& queue, const Push& push) {
    std::vector<std::uint64_t> popped, pushed_out;
    std::atomic<bool> done{false};
    {
      const std::jthread writer([&, seed = random()] {
        Random dice(seed);
        for (std::uint64_t n = 0; n < count_; ++n) {
          if (const auto out = push(queue, n)) pushed_out.push_back(*out);
          if (dice() % 8 == 0) std::this_thread::yield();
        }
        done = true;
      });
      for (bool was_done = false; !was_done;) {
        was_done = done;
        while (const auto number = queue.pop()) popped.push_back(*number);
        std::this_thread::yield();
      }
    }
    EXPECT_TRUE(std::ranges::is_sorted(popped)) << "they come in order";
    popped.insert(popped.end(), pushed_out.begin(), pushed_out.end());
    std::ranges::sort(popped);
    return popped;
  }
  std::vector<std::uint64_t> all_numbers() const {
    std::vector<std::uint64_t> all(count_);
    std::iota(all.begin(), all.end(), 0);
    return all;
  }

  const std::uint64_t count_ = test_rounds(2'000);
};

TEST_F(QueueTest, HandsEachElementOverOnceAndInOrder) {
  for (const std::uint64_t capacity : {1U, 2U, 4U, 256U}) {
    const auto queue = std::make_unique<Queue>(capacity);
    const auto push = [](Queue& to, std::uint64_t n) {
      while (!to.tryPush(n)) std::this_thread::yield();
      return std::optional<std::uint64_t>();
    };
    EXPECT_EQ(numbers_through(*queue, push), all_numbers()) << "capacity " << capacity;
    EXPECT_EQ(queue->size(), 0U);
  }
}

TEST_F(QueueTest, PushesTheOldestElementOutIfItIsFull) {
  for (const std::uint64_t capacity : {1U, 2U, 4U}) {
    const auto queue = std::make_unique<Queue>(capacity);
    const auto push = [](Queue& to, std::uint64_t n) {
      const auto out = to.push(n);
      return out.has_value() ? std::optional<std::uint64_t>(out.value()) : std::nullopt;
    };
    EXPECT_EQ(numbers_through(*queue, push), all_numbers()) << "capacity " << capacity;
    EXPECT_EQ(queue->size(), 0U);
  }
}

}  // namespace
}  // namespace sft::test
