#include "udp_transport/receive/keep_last_queue.h"

#include <gtest/gtest.h>
#include <malloc.h>

#include <vector>

#include "core/seam/buffer_pool.h"

namespace sft::udp {
namespace {

class KeepLastQueueTest : public testing::Test {
 protected:
  using Put = KeepLastQueue::Put;
  using Sequences = std::vector<std::uint64_t>;

  Put put(std::uint64_t sequence, std::uint32_t body_bytes = 0,
          KeepLastQueue::Excess excess = KeepLastQueue::Excess::pushed_out) {
    core::SampleHandle sample = pool_->take(100);
    sample->header().sequence = sequence;
    sample->header().body_bytes = body_bytes;
    const Put result = queue_.put(sample, ++arrivals_, excess);
    if (result == Put::pushed_out) pushed_out_.push_back(sample->header().sequence);
    return result;
  }
  /// Returns how many further samples of that size can wait.
  std::size_t room(std::uint64_t body_bytes = 0) const {
    KeepLastQueue::Room room = queue_.room();
    std::size_t samples = 0;
    while (room.take(body_bytes)) ++samples;
    return samples;
  }
  std::uint64_t pop() { return queue_.pop()->header().sequence; }
  Sequences pop_all() {
    Sequences sequences;
    while (!queue_.empty()) sequences.push_back(pop());
    return sequences;
  }

  std::shared_ptr<core::BufferPool> pool_ = core::BufferPool::make(1 << 20);
  KeepLastQueue queue_{3};
  std::uint64_t arrivals_ = 0;
  Sequences pushed_out_;
};

TEST_F(KeepLastQueueTest, GivesSamplesInTheOrderOfTheirSequences) {
  for (const std::uint64_t sequence : {5U, 7U, 6U}) EXPECT_EQ(put(sequence), Put::kept);
  EXPECT_EQ(pop_all(), (Sequences{5, 6, 7}));
}

TEST_F(KeepLastQueueTest, PushesTheOldestOut) {
  for (std::uint64_t sequence = 1; sequence <= 10; ++sequence) put(sequence);
  EXPECT_EQ(pushed_out_, (Sequences{1, 2, 3, 4, 5, 6, 7}));
  EXPECT_EQ(pop_all(), (Sequences{8, 9, 10}));
}

TEST_F(KeepLastQueueTest, PushesTheOldestOutThatHaveTooManyBytes) {
  queue_ = KeepLastQueue(3, 100);
  put(1, 50);
  put(2, 40);
  EXPECT_EQ(put(3, 10), Put::kept);
  EXPECT_EQ(put(4, 60), Put::pushed_out) << "for its place, and because of its bytes";
  EXPECT_EQ(pushed_out_, (Sequences{2}));
  EXPECT_EQ(queue_.take_dropped(), 1U) << "the first one";
  EXPECT_EQ(pop_all(), (Sequences{3, 4}));
  EXPECT_EQ(put(5, 90), Put::kept) << "what was taken has no bytes any more";
}

TEST_F(KeepLastQueueTest, CountsEachOfSeveralThatHaveToGoForOne) {
  queue_ = KeepLastQueue(3, 100);
  put(1, 40);
  put(2, 40);
  EXPECT_EQ(put(3, 90), Put::pushed_out);
  EXPECT_EQ(pushed_out_, (Sequences{2}));
  EXPECT_EQ(queue_.take_dropped(), 1U) << "the first one";
  EXPECT_EQ(pop_all(), (Sequences{3}));
}

TEST_F(KeepLastQueueTest, CountsWhatGoesWhereSequencesBeginAnewAndHasItsRoomBack) {
  queue_ = KeepLastQueue(3, 100);
  put(10, 60);
  put(11, 30);
  core::SampleHandle first = pool_->take(100);
  first->header().sequence = 5;
  first->header().body_bytes = 80;
  first->numbering = 1;
  EXPECT_EQ(queue_.put(first, ++arrivals_), Put::kept);
  EXPECT_EQ(queue_.take_dropped(), 2U);
  EXPECT_EQ(put(6, 20), Put::kept);
  EXPECT_EQ(pop_all(), (Sequences{5, 6}));
}

TEST_F(KeepLastQueueTest, KeepsASampleAloneThatHasMoreBytesThanMayWait) {
  queue_ = KeepLastQueue(3, 100);
  put(1, 60);
  put(2, 1000);
  EXPECT_EQ(pop_all(), (Sequences{2}));
}

TEST_F(KeepLastQueueTest, HasRoomForAsManySamplesAsItsDepthAllows) {
  EXPECT_EQ(room(), 3U);
  put(1, 1000);
  EXPECT_EQ(room(1'000'000), 2U) << "no limit of bytes";
  put(2);
  put(3);
  EXPECT_EQ(room(), 0U);
}

TEST_F(KeepLastQueueTest, HasRoomForAsManyBytesAsMayWait) {
  queue_ = KeepLastQueue(3, 100);
  EXPECT_EQ(room(50), 2U) << "as many when nothing has come yet";
  put(1, 40);
  EXPECT_EQ(room(60), 1U);
  EXPECT_EQ(room(61), 0U);
  EXPECT_EQ(room(20), 2U) << "whatever the size of the last one";
  put(2, 40);
  EXPECT_EQ(room(40), 0U);
  pop_all();
  EXPECT_EQ(room(1000), 1U) << "one of any size";
}

TEST_F(KeepLastQueueTest, PushesNothingOutForBytesWhereThePublisherWaits) {
  queue_ = KeepLastQueue(3, 100);
  put(1, 10);
  for (const std::uint64_t sequence : {2U, 3U})
    EXPECT_EQ(put(sequence, 90, KeepLastQueue::Excess::kept), Put::kept);
  EXPECT_EQ(room(), 0U);
  EXPECT_EQ(queue_.take_dropped(), 0U);
  EXPECT_EQ(pop_all(), (Sequences{1, 2, 3}));
}

#ifndef SFT_TEST_SANITIZED  // the sanitizers have an allocator of their own
TEST_F(KeepLastQueueTest, HasNoMemoryOfAPeakOnceItIsEmpty) {
  const auto lent_bytes = [] { return mallinfo2().uordblks + mallinfo2().hblkhd; };
  pool_ = core::BufferPool::make(64 << 20);
  queue_ = KeepLastQueue(20'000);
  for (std::uint64_t sequence = 1; sequence <= 20'000; ++sequence) put(sequence);
  const std::size_t at_the_peak = lent_bytes();
  while (!queue_.empty()) pop();
  EXPECT_LT(lent_bytes() + 200'000, at_the_peak) << "the pool keeps the samples, and a list of them";
}
#endif

TEST_F(KeepLastQueueTest, TakesNoSampleTwice) {
  put(1);
  EXPECT_EQ(put(1), Put::repeated);
  EXPECT_EQ(pop(), 1U);
  EXPECT_EQ(put(1), Put::late);
}

TEST_F(KeepLastQueueTest, RefusesWhatIsOlderThanOneAlreadyTaken) {
  put(5);
  pop();
  EXPECT_EQ(put(4), Put::late);
  EXPECT_EQ(put(6), Put::kept);
}

TEST_F(KeepLastQueueTest, RefusesALateSampleThatWouldBeTheOldestOfAFullQueue) {
  for (const std::uint64_t sequence : {5U, 6U, 7U}) put(sequence);
  EXPECT_EQ(put(4), Put::late);
  EXPECT_EQ(pop_all(), (Sequences{5, 6, 7}));
}

TEST_F(KeepLastQueueTest, SortsALateSampleIntoAFullQueue) {
  for (const std::uint64_t sequence : {4U, 6U, 8U}) put(sequence);
  EXPECT_EQ(put(7), Put::pushed_out);
  EXPECT_EQ(pushed_out_, (Sequences{4}));
  EXPECT_EQ(pop_all(), (Sequences{6, 7, 8}));
}

TEST_F(KeepLastQueueTest, KeepsItsOrderWhileItGrowsAndTurns) {
  KeepLastQueue queue(100);
  std::uint64_t next = 1, expected = 1;
  for (int round = 0; round < 500; ++round) {
    for (int i = 0; i < 3; ++i) {
      core::SampleHandle sample = pool_->take(100);
      sample->header().sequence = next++;
      ASSERT_NE(queue.put(sample, next), Put::late);
      if (sample) expected = sample->header().sequence + 1;
    }
    for (int i = 0; i < (round % 4 == 0 ? 1 : 2); ++i) ASSERT_EQ(queue.pop()->header().sequence, expected++);
  }
}

}  // namespace
}  // namespace sft::udp
