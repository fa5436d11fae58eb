// A publisher retains samples for late readers.
#include "core/publish/history.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/seam/buffer_pool.h"

namespace sft::core {
namespace {

class HistoryTest : public ::testing::Test {
 protected:
  /// Returns a sample whose stamp is its sequence.
  SampleHandle sample(std::uint64_t sequence) {
    SampleHandle s = pool->take(256);
    s->header().sequence = sequence;
    s->header().source_stamp_ns = static_cast<std::int64_t>(sequence);
    s->trust_header();
    return s;
  }
  static std::vector<std::uint64_t> sequences(const std::vector<SampleHandle>& samples) {
    std::vector<std::uint64_t> s;
    for (const SampleHandle& one : samples) s.push_back(one->header().sequence);
    return s;
  }
  using Sequences = std::vector<std::uint64_t>;
  const std::shared_ptr<BufferPool> pool = BufferPool::make(16 * 512);
};

TEST_F(HistoryTest, KeepsAnotherCopyOfASampleForItAsLongAsThatIsKept) {
  History history(2, 0);
  for (std::uint64_t n = 1; n <= 3; ++n) history.add(sample(n));
  const SampleHandle two = sample(2);
  history.replace(two);
  history.replace(sample(1));
  const auto kept = history.last(2, 0);
  EXPECT_EQ(sequences(kept), (Sequences{2, 3}));
  EXPECT_EQ(kept.at(0)->data, two->data);
}

TEST_F(HistoryTest, KeepsTheLastSamplesInOrder) {
  History history(3, 0);
  EXPECT_TRUE(history.last(3, 0).empty());
  history.add(sample(1));
  history.add(sample(2));
  EXPECT_EQ(sequences(history.last(3, 0)), (Sequences{1, 2}));
  for (std::uint64_t n = 3; n <= 7; ++n) history.add(sample(n));
  EXPECT_EQ(sequences(history.last(3, 0)), (Sequences{5, 6, 7}));
  EXPECT_EQ(sequences(history.last(2, 0)), (Sequences{6, 7}));
  EXPECT_EQ(sequences(history.last(100, 0)), (Sequences{5, 6, 7}));
}

TEST_F(HistoryTest, HoldsNoMoreMemoryThanItsDepth) {
  History history(4, 0);
  for (std::uint64_t n = 1; n <= 1000; ++n) {
    const SampleHandle s = sample(n);
    ASSERT_TRUE(s) << n;  // the pool can lend 16 such buffers
    history.add(s);
  }
}

TEST_F(HistoryTest, LetsGoOfWhatHasExpired) {
  History history(8, 10);
  for (std::uint64_t n = 1; n <= 8; ++n) history.add(sample(n));
  EXPECT_EQ(sequences(history.last(8, 15)), (Sequences{5, 6, 7, 8}));
  const SampleHandle oldest = history.last(8, 0).front();
  EXPECT_EQ(oldest->references, 2U);
  history.expire(15);
  EXPECT_EQ(oldest->references, 1U);
  EXPECT_EQ(sequences(history.last(8, 15)), (Sequences{5, 6, 7, 8}));
}

}  // namespace
}  // namespace sft::core
