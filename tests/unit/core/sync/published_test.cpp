// A value that one thread replaces while another thread reads it, and the wait for readers of the former
// value.
#include "core/sync/published.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <chrono>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

namespace sft::core {
namespace {

using namespace std::chrono_literals;

TEST(PublishedTest, AReaderSeesTheLatestValueAndKeepsItWhileItIsReplaced) {
  Published<int> value;
  value.replace(std::make_shared<int>(1));
  const int* first = value.load();
  value.replace(std::make_shared<int>(2));
  EXPECT_EQ(*first, 1);
  EXPECT_EQ(*value.load(), 2);
  EXPECT_EQ(value.load(), value.loaded().get());
  EXPECT_EQ(value.loaded(), value.share());
}

TEST(PublishedTest, ValuesNeverGoBackWhileOneThreadReplacesThemAndAnotherReads) {
  Published<int> value;
  value.replace(std::make_shared<int>(0));
  std::thread writer([&] {
    for (int i = 1; i <= 20'000; ++i) value.replace(std::make_shared<int>(i));
  });
  int last = 0;
  while (last < 20'000) {
    const int now = *value.load();
    ASSERT_GE(now, last);
    last = now;
  }
  writer.join();
}

TEST(PublishedTest, WithoutAReadingThereIsNothingToWaitFor) {
  Published<int> value;
  value.wait_for_reader();
  { const Published<int>::Reading reading(value); }
  value.wait_for_reader();
}

TEST(PublishedTest, WhoeverReplacesTheValueWaitsForAReadingThatUsesTheFormerOne) {
  Published<int> value;
  value.replace(std::make_shared<int>(1));
  std::atomic<bool> reads{false}, replaced{false};
  bool ended = false;  // not atomic, because the sanitizers check that wait_for_reader() orders the accesses
                       // of the threads
  std::thread reader([&] {
    const Published<int>::Reading reading(value);
    const int* former = value.load();
    reads = true;
    reads.notify_all();
    replaced.wait(false);
    // The loop gives the other thread the chance to return too early.
    for (int i = 0; i < 1000; ++i) std::this_thread::yield();
    EXPECT_EQ(*former, 1);
    ended = true;
  });
  reads.wait(false);
  value.replace(std::make_shared<int>(2));
  replaced = true;
  replaced.notify_all();
  value.wait_for_reader();
  EXPECT_TRUE(ended);
  reader.join();
}

// The waiting thread cannot report when it has begun to wait. So this thread begins a new Reading again and
// again, and at least one Reading always exists. If the waiting thread also waited for later Readings, it
// would wait for ever.
TEST(PublishedTest, AReadingThatBeginsMeanwhileIsNotWaitedFor) {
  Published<int> value;
  std::optional<Published<int>::Reading> reading(std::in_place, value);
  auto waiting = std::async(std::launch::async, [&] { value.wait_for_reader(); });
  const auto deadline = std::chrono::steady_clock::now() + 10s;
  do {
    reading.emplace(value);
  } while (waiting.wait_for(1ms) != std::future_status::ready && std::chrono::steady_clock::now() < deadline);
  EXPECT_EQ(waiting.wait_for(0s), std::future_status::ready);
  reading.reset();
}

// A Reading must be visible before the value is loaded. A wrong order would rarely cause a failure, so this
// test may miss it. tests/model/routes.pml detects this fault (announced_late).
TEST(PublishedTest, AfterTheWaitNoReadingUsesAFormerValue) {
  using Alive = std::atomic<bool>;
  Published<Alive> latest;
  auto present = std::make_shared<Alive>(true);
  latest.replace(present);
  std::atomic<bool> stop{false};
  std::uint64_t dead = 0;
  std::thread reader([&] {
    while (!stop) {
      const Published<Alive>::Reading reading(latest);
      const Alive* value = latest.load();
      for (int i = 0; i < 10; ++i) dead += value->load(std::memory_order_relaxed) ? 0 : 1;
    }
  });
  for (int i = 0; i < 2000; ++i) {
    const auto former = std::exchange(present, std::make_shared<Alive>(true));
    latest.replace(present);
    latest.wait_for_reader();
    former->store(false, std::memory_order_relaxed);
  }
  stop = true;
  reader.join();
  EXPECT_EQ(dead, 0U);
}

TEST(PublishedTest, SeveralThreadsMayReplaceItAndEachWaitsUntilItsFormerValueIsNotUsed) {
  using Plain = std::unique_ptr<int>;  // lets the sanitizers detect a use after the destruction
  Published<Plain> latest;
  latest.replace(std::make_shared<Plain>(std::make_unique<int>(0)));
  std::atomic<bool> stop{false};
  std::int64_t sum = 0;
  std::thread reader([&] {
    while (!stop) {
      const Published<Plain>::Reading reading(latest);
      sum += **latest.load();
    }
  });
  std::mutex replacing;
  const auto replace = [&] {
    for (int i = 0; i < 500; ++i) {
      auto next = std::make_shared<Plain>(std::make_unique<int>(1));
      std::shared_ptr<const Plain> former;
      {
        const std::scoped_lock lock(replacing);
        former = latest.share();
        latest.replace(std::move(next));
      }
      latest.wait_for_reader();
      const_cast<Plain&>(*former).reset();
    }
  };
  std::array<std::thread, 3> writers{std::thread(replace), std::thread(replace), std::thread(replace)};
  for (std::thread& writer : writers) writer.join();
  stop = true;
  reader.join();
  EXPECT_GE(sum, 0);
}

}  // namespace
}  // namespace sft::core
