#include "core/seam/buffer_pool.h"

#include <gtest/gtest.h>
#include <malloc.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <memory>
#include <vector>

#include "core/platform/huge_pages.h"
#include "tests/support/cleared_pages.h"

namespace sft::core {
namespace {

using namespace detail;

TEST(BufferPoolTest, ABufferHasRoomIsAlignedAndBeginsWithAFreshHeader) {
  const auto pool = BufferPool::make(1 << 20);
  const SampleHandle buffer = pool->take(1000);
  ASSERT_TRUE(buffer);
  EXPECT_GE(buffer->capacity, 1000U);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(buffer->data) % 8, 0U);
  EXPECT_EQ(buffer->header().magic, sample_magic);
}

TEST(BufferPoolTest, AReleasedBufferIsUsedAgain) {
  const auto pool = BufferPool::make(1 << 20);
  SampleHandle buffer = pool->take(1000);
  const std::byte* memory = buffer->data;
  buffer.reset();
  EXPECT_EQ(pool->take(900)->data, memory);
}

constexpr std::size_t large_bytes = 4'000'000;

/// Returns true if the system has provided memory for the whole buffer.
bool is_resident(const SampleHandle& buffer) {
  const std::size_t page_bytes = test::page_bytes();
  const auto begin = reinterpret_cast<std::uintptr_t>(buffer->data) / page_bytes * page_bytes;
  std::vector<unsigned char> pages(buffer->capacity / page_bytes);
  EXPECT_EQ(mincore(reinterpret_cast<void*>(begin), pages.size() * page_bytes, pages.data()), 0);
  return std::ranges::all_of(pages, [](unsigned char page) { return (page & 1U) != 0; });
}

TEST(BufferPoolTest, LargeBuffersThatAreExpectedAreReadyWhenTheyAreTaken) {
  malloc_trim(0);  // returns freed memory to the system; it would be reused, although it is already resident
  const auto pool = BufferPool::make(256 << 20);
  const SampleHandle unexpected = pool->take(large_bytes);
  ASSERT_TRUE(unexpected);
  EXPECT_FALSE(is_resident(unexpected)) << "else the next expectation says nothing";
  pool->expect(large_bytes);
  pool->stock();
  const SampleHandle first = pool->take(large_bytes), second = pool->take(large_bytes);
  ASSERT_TRUE(first && second);
  EXPECT_TRUE(is_resident(first) && is_resident(second));
}

std::size_t kept_by(BufferPool& pool, std::size_t bytes) {
  std::vector<SampleHandle> kept;
  pool.take_kept(bytes, 0, 10, kept);
  return kept.size();
}

/// Takes `count` buffers at the same time.
std::vector<SampleHandle> take(BufferPool& pool, std::size_t count, std::size_t bytes = large_bytes) {
  std::vector<SampleHandle> taken(count);
  for (SampleHandle& one : taken) one = pool.take(bytes);
  return taken;
}

TEST(BufferPoolTest, WhatWasNotNeededForAWholePeriodGoesBackToTheSystem) {
  const auto pool = BufferPool::make(256 << 20);
  const Time begin = std::chrono::steady_clock::now();
  constexpr auto period = BufferPool::period;
  pool->give_back(begin);
  take(*pool, 10);  // a peak of 10 buffers
  EXPECT_EQ(kept_by(*pool, large_bytes), 10U);
  pool->give_back(begin + period);
  EXPECT_EQ(kept_by(*pool, large_bytes), 10U) << "they were needed in this period";
  for (int i = 0; i < 100; ++i) take(*pool, 3);
  pool->give_back(begin + 2 * period - std::chrono::milliseconds(1));
  EXPECT_EQ(kept_by(*pool, large_bytes), 10U) << "the period is not over";
}

/// Returns the size in bytes of the memory of this process that the system has provided.
std::size_t resident_bytes() {
  std::size_t mapped = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> mapped >> resident;
  return resident * test::page_bytes();
}

/// The C library keeps blocks of all sizes up to the largest one that the program has freed.
TEST(BufferPoolTest, WhatGoesBackLeavesTheProcessWhateverTheProgramHasFreedBefore) {
  void* volatile freed = std::malloc(32 << 20);
  std::free(freed);
  for (const std::size_t bytes : {2'000U, 9'000U, 20'000U, 70'000U, 500'000U, 1'500'000U, 4'000'000U}) {
    // Each buffer is described by an object of some 300 bytes that the C library may keep. Sanitizers keep
    // more of each object.
#ifdef SFT_TEST_SANITIZED
    const std::size_t left_max = (bytes < 10'000 ? 32 : 4) << 20;
#else
    const std::size_t left_max = (bytes < 10'000 ? 12 : 4) << 20;
#endif
    const auto pool = BufferPool::make(256 << 20);
    const std::size_t count = (64 << 20) / bytes;
    const std::size_t before = resident_bytes();
    void* above = nullptr;
    {
      const std::vector<SampleHandle> taken = take(*pool, count, bytes);
      for (const SampleHandle& one : taken) std::memset(one->data + 100, 1, bytes - 100);
      above = std::malloc(1000);  // so that the blocks below cannot leave the heap
      EXPECT_GT(resident_bytes(), before + (60 << 20)) << bytes;
    }
    Time now = std::chrono::steady_clock::now();
    for (int calls = 0; calls < 50; ++calls) pool->give_back(now += BufferPool::period);
    EXPECT_LT(resident_bytes(), before + left_max) << bytes;
    std::free(above);
  }
}

TEST(BufferPoolTest, LargeBuffersBeginWithAHugePage) {
  const auto pool = BufferPool::make(256 << 20);
  for (int i = 0; i < 3; ++i) {
    const std::vector<SampleHandle> taken = take(*pool, 5);
    for (const SampleHandle& one : taken)
      EXPECT_EQ(reinterpret_cast<std::uintptr_t>(one->data) % huge_page_bytes, 0U);
  }
}

TEST(BufferPoolTest, VeryManyBuffersGoBackInParts) {
  const auto pool = BufferPool::make(256 << 20);
  Time now = std::chrono::steady_clock::now();
  constexpr std::size_t many = 5'000, bytes = 500;
  take(*pool, many, bytes);
  pool->give_back(now);
  pool->give_back(now += BufferPool::period);
  {
    std::vector<SampleHandle> kept;
    pool->take_kept(bytes, 0, many, kept);
    EXPECT_GT(kept.size(), 0U) << "one call would hold up its thread";
    EXPECT_LT(kept.size(), many);
  }
  for (int calls = 0; calls < 10; ++calls) pool->give_back(now += BufferPool::period);
  EXPECT_EQ(kept_by(*pool, bytes), 0U);
}

TEST(BufferPoolTest, WhatWasNeededIsKeptAlsoWhereTheOthersGoBackInParts) {
  const auto pool = BufferPool::make(256 << 20);
  Time now = std::chrono::steady_clock::now();
  constexpr std::size_t many = 3'000, needed = 100, bytes = 500;
  take(*pool, many, bytes);
  pool->give_back(now);
  take(*pool, needed, bytes);
  now += BufferPool::period;
  for (int calls = 0; calls < 10; ++calls) pool->give_back(now);
  std::vector<SampleHandle> kept;
  pool->take_kept(bytes, 0, many, kept);
  EXPECT_EQ(kept.size(), needed);
}

TEST(BufferPoolTest, WhatWentBackToTheSystemLeavesRoomForAsMuch) {
  const auto pool = BufferPool::make(12 * large_bytes);
  Time now = std::chrono::steady_clock::now();
  for (int peak = 0; peak < 100; ++peak) {
    for (const SampleHandle& one : take(*pool, 4)) ASSERT_TRUE(one) << peak;
    for (int calls = 0; calls < 3; ++calls) pool->give_back(now += BufferPool::period);
    ASSERT_EQ(kept_by(*pool, large_bytes), 0U);
  }
}

TEST(BufferPoolTest, WhatIsInUseAgainAndAgainIsKept) {
  const auto pool = BufferPool::make(256 << 20);
  Time now = std::chrono::steady_clock::now();
  pool->give_back(now);
  take(*pool, 10);
  for (int i = 0; i < 5; ++i) {
    pool->give_back(now += BufferPool::period);
    take(*pool, 3);
  }
  EXPECT_EQ(kept_by(*pool, large_bytes), 3U);
  pool->give_back(now += BufferPool::period);
  pool->give_back(now += BufferPool::period);
  EXPECT_EQ(kept_by(*pool, large_bytes), 0U) << "nobody sends any more";
}

TEST(BufferPoolTest, StocksNothingThatIsSmallOrWasNotExpectedOrIsStillKept) {
  const auto pool = BufferPool::make(256 << 20);
  const SampleHandle taken = pool->take(large_bytes);
  pool->expect(10'000);
  pool->stock();
  EXPECT_EQ(kept_by(*pool, large_bytes), 0U);
  EXPECT_EQ(kept_by(*pool, 10'000), 0U);
  for (int i = 0; i < 3; ++i) {
    pool->expect(large_bytes);
    pool->stock();
  }
  EXPECT_EQ(kept_by(*pool, large_bytes), 2U);
}

TEST(BufferPoolTest, StocksNothingThatWouldTakeTooMuchOfTheLimit) {
  const auto pool = BufferPool::make(4 * large_bytes);
  pool->expect(large_bytes);
  pool->stock();
  EXPECT_EQ(kept_by(*pool, large_bytes), 0U);
}

TEST(BufferPoolTest, ABufferGoesBackOnlyWithItsLastHandle) {
  const auto pool = BufferPool::make(1 << 20);
  SampleHandle first = pool->take(1000);
  const SampleHandle second = first;
  first.reset();
  EXPECT_NE(pool->take(1000)->data, second->data);
}

TEST(BufferPoolTest, BeyondTheLimitThereIsNoBufferUntilOneIsReleased) {
  const auto pool = BufferPool::make(5000);
  SampleHandle first = pool->take(4096);
  EXPECT_TRUE(first);
  EXPECT_FALSE(pool->take(1));
  first.reset();
  EXPECT_TRUE(pool->take(1));  // the pool frees the large kept buffer to make this one
}

TEST(BufferPoolTest, ARoundBodyWithItsHeaderAndIndexTakesLittleMoreThanItself) {
  for (const std::size_t body : {4096U, 65'536U, 1U << 20, 4U << 20, 16U << 20}) {
    const auto pool = BufferPool::make(body + body / 8);
    const SampleHandle buffer = pool->take(body + 64 + 4 * 73 + 8);
    ASSERT_TRUE(buffer) << body;
    EXPECT_LE(buffer->capacity, body + std::min<std::size_t>(body / 8, 8192));
  }
}

TEST(BufferPoolTest, EverySizeGetsRoomAndIsUsedAgain) {
  const auto pool = BufferPool::make(std::size_t{1} << 30);
  for (std::size_t bytes = 1; bytes < 64U << 20; bytes += 1 + bytes / 3) {
    SampleHandle buffer = pool->take(bytes);
    ASSERT_TRUE(buffer) << bytes;
    EXPECT_GE(buffer->capacity, bytes);
    const std::byte* memory = buffer->data;
    const std::size_t capacity = buffer->capacity;
    buffer.reset();
    EXPECT_EQ(pool->take(capacity)->data, memory) << bytes;
  }
}

TEST(BufferPoolTest, SomeCanBeLeftToOthers) {
  const auto pool = BufferPool::make(10'000);
  SampleHandle first = pool->take(4096, 5000);
  EXPECT_TRUE(first);
  EXPECT_FALSE(pool->take(4096, 5000));
  EXPECT_TRUE(pool->take(4096));
  EXPECT_FALSE(pool->take(4096, 5000)) << "what is kept for use again does not count";
  first.reset();
  EXPECT_TRUE(pool->take(4096, 5000));
}

TEST(BufferPoolTest, HandsOutUpToTheRequestedNumberOfKeptBuffers) {
  const auto pool = BufferPool::make(1 << 20);
  { const std::array kept{pool->take(1000), pool->take(1000), pool->take(1000), pool->take(1000)}; }
  std::vector<SampleHandle> buffers;
  pool->take_kept(1000, 0, 3, buffers);
  EXPECT_EQ(buffers.size(), 3U);
  pool->take_kept(1000, 0, 3, buffers);
  EXPECT_EQ(buffers.size(), 4U);
}

TEST(BufferPoolTest, LeavesSomeOfTheKeptBuffersToOthers) {
  constexpr std::size_t limit = 10'000;
  const auto pool = BufferPool::make(limit);
  std::size_t capacity = 0;
  {
    const std::array kept{pool->take(1000), pool->take(1000), pool->take(1000), pool->take(1000)};
    capacity = kept.front()->capacity;
  }
  std::vector<SampleHandle> buffers;
  pool->take_kept(1000, limit - 2 * capacity, 4, buffers);
  EXPECT_EQ(buffers.size(), 2U);
  EXPECT_FALSE(pool->take(1000, limit - 2 * capacity)) << "these are lent";
  EXPECT_TRUE(pool->take(1000, limit - 3 * capacity));
  buffers.clear();
  EXPECT_TRUE(pool->take(1000, limit - capacity)) << "all are back";
}

// The sanitizers end a process when an allocation fails.
#ifndef SFT_TEST_SANITIZED
TEST(BufferPoolTest, WhatTheSystemHasNoMemoryForDoesNotCount) {
  // The C library asks the system for each block of this size, and keeps no such block from earlier tests.
  constexpr std::size_t large = 64U << 20;
  const auto pool = BufferPool::make(large + large / 8);
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_AS, &before), 0);
  const rlimit none{.rlim_cur = 1, .rlim_max = before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_AS, &none), 0);
  const bool taken = static_cast<bool>(pool->take(large));
  ASSERT_EQ(setrlimit(RLIMIT_AS, &before), 0);
  EXPECT_FALSE(taken);
  EXPECT_TRUE(pool->take(large));
}
#endif

TEST(BufferPoolTest, AnImpossibleSizeIsRefused) {
  EXPECT_FALSE(BufferPool::make(std::size_t{1} << 40)->take(std::size_t{1} << 33));
}

TEST(BufferPoolTest, AHandleKeepsItsPoolAlive) {
  std::shared_ptr<BufferPool> pool = BufferPool::make(1 << 20);
  const std::weak_ptr<BufferPool> watched = pool;
  SampleHandle buffer = pool->take(64);
  pool.reset();
  EXPECT_FALSE(watched.expired());
  buffer->data[63] = std::byte{1};
  EXPECT_EQ(buffer->data[63], std::byte{1});
  buffer.reset();
  EXPECT_TRUE(watched.expired());
}

}  // namespace
}  // namespace sft::core
