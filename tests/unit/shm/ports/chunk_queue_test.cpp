// These tests check which chunks a reader may borrow from its queue. The port and the pool of chunks are in
// the memory of this process.
#include "shm_transport/ports/chunk_queue.h"

#include <gtest/gtest.h>

#include <cstring>
#include <iceoryx_posh/mepoo/mepoo_config.hpp>
#include <iceoryx_posh/roudi/port_pool.hpp>
#include <memory>
#include <vector>

#include "shm_transport/host/chunk_hand.h"
#include "shm_transport/host/queue_places.h"

namespace sft::shm {
namespace {

constexpr std::uint32_t chunk_bytes = 128;
constexpr std::uint64_t queue_capacity = 2;

class ChunkQueueTest : public ::testing::Test {
 protected:
  ChunkQueueTest() {
    pools_config_.addMemPool({chunk_bytes, 16});
    management_.resize(iox::mepoo::MemoryManager::requiredManagementMemorySize(pools_config_) / 8 + 8);
    samples_.resize(iox::mepoo::MemoryManager::requiredChunkMemorySize(pools_config_) / 8 + 8);
    iox::posix::Allocator management(management_.data(), management_.size() * 8);
    iox::posix::Allocator samples(samples_.data(), samples_.size() * 8);
    memory_.configureMemoryManager(pools_config_, management, samples);
    iox::popo::SubscriberOptions options;
    options.queueCapacity = queue_capacity;
    port_ = pool_.addSubscriberPort({"sft", "w", "1"}, "sft_node", options, iox::mepoo::MemoryInfo{}).value();
    open_queue();
  }
  void open_queue() { queue_ = std::make_unique<ChunkQueue>(*port_, 2, FieldMask{}); }

  /// Delivers chunks to the queue as a writer does.
  void arrive(int count) {
    iox::popo::ChunkQueuePusher<iox::popo::SubscriberPortData::ChunkQueueData_t> writer(
        &port_->m_chunkReceiverData);
    for (; count > 0; --count) {
      const auto settings = iox::mepoo::ChunkSettings::create(chunk_bytes, 8).value();
      if (!writer.push(memory_.getChunk(settings).value())) writer.lostAChunk();
    }
  }
  void deliver(QueuePlaces& places) {
    places.make_room();
    arrive(1);
  }
  std::uint32_t in_use() const { return memory_.getMemPoolInfo(0).m_usedChunks; }

  /// Finds the word of the queue that `read` returns, and overwrites it with `value`, as a hostile program
  /// could.
  template <class Read>
  void forge(std::uint64_t value, const Read& read) {
    auto& queue = port_->m_chunkReceiverData.m_queue;
    auto* const words = reinterpret_cast<std::byte*>(&queue);
    const auto put = [&](std::size_t at, std::uint64_t word) { std::memcpy(words + at, &word, sizeof word); };
    const std::uint64_t honest = read(queue);
    for (std::size_t at = 0; at + sizeof honest <= sizeof queue; at += sizeof honest) {
      std::uint64_t word = 0;
      std::memcpy(&word, words + at, sizeof word);
      if (word != honest) continue;
      put(at, honest + 1);
      const bool found = read(queue) == honest + 1;
      put(at, found ? value : word);
      if (found) return;
    }
    ADD_FAILURE() << "the queue has no such word";
  }
  void forge_capacity(std::uint64_t capacity) {
    forge(capacity, [](const auto& queue) { return queue.capacity(); });
    ASSERT_EQ(queue_->capacity(), capacity);
  }
  void forge_size(std::uint64_t size) {
    forge(size, [](auto& queue) { return queue.size(); });
    ASSERT_EQ(port_->m_chunkReceiverData.m_queue.size(), size);
  }
  /// Takes all samples, and gives each sample back before the next sample is taken. Returns their number.
  std::uint64_t take_all() {
    std::uint64_t taken = 0;
    for (ChunkSlot* slot = queue_->take().slot; slot != nullptr; slot = queue_->take().slot, ++taken)
      queue_->give_back(*slot);
    return taken;
  }

  iox::mepoo::MePooConfig pools_config_;
  std::vector<std::uint64_t> management_, samples_;
  iox::mepoo::MemoryManager memory_;
  const std::unique_ptr<iox::roudi::PortPoolData> ports_ = std::make_unique<iox::roudi::PortPoolData>();
  iox::roudi::PortPool pool_{*ports_};
  iox::popo::SubscriberPortData* port_ = nullptr;
  std::unique_ptr<ChunkQueue> queue_;
};

TEST_F(ChunkQueueTest, NoMoreChunksAreBorrowedThanTheLimitAndThisIsToldOnce) {
  arrive(2);
  ChunkSlot* const first = queue_->take().slot;
  ASSERT_NE(first, nullptr);
  EXPECT_EQ(queue_->take().popped, 2U);
  arrive(1);
  EXPECT_TRUE(queue_->take().limit_reached);
  EXPECT_FALSE(queue_->take().limit_reached);
  EXPECT_TRUE(queue_->some_wait());
  queue_->give_back(*first);
  EXPECT_NE(queue_->take().slot, nullptr);
}

TEST_F(ChunkQueueTest, AnOverflowIsToldWithTheNextChunkAlsoIfArrivalsNoticedItFirst) {
  arrive(3);
  EXPECT_EQ(queue_->arrivals(), 3U);
  const ChunkQueue::Taken first = queue_->take();
  EXPECT_TRUE(first.overflowed);
  EXPECT_FALSE(queue_->take().overflowed);
}

TEST_F(ChunkQueueTest, OnlySamplesThatArrivedBeforeTheQueueWasClosedCanBeTaken) {
  arrive(1);
  queue_->close();
  arrive(1);
  EXPECT_FALSE(queue_->open());
  EXPECT_EQ(queue_->left(), 1U);
  EXPECT_NE(queue_->take().slot, nullptr);
  EXPECT_TRUE(queue_->drained());
  EXPECT_EQ(queue_->take().slot, nullptr);
}

TEST_F(ChunkQueueTest, AChunkThatIsDroppedIsFree) {
  arrive(2);
  EXPECT_FALSE(queue_->drop_oldest()) << "the queue is open";
  queue_->close();
  EXPECT_TRUE(queue_->drop_oldest());
  EXPECT_EQ(in_use(), 1U);
  EXPECT_EQ(queue_->left(), 1U);
}

TEST_F(ChunkQueueTest, AClosedQueueTellsTheBytesThatAreLeft) {
  arrive(2);
  EXPECT_EQ(queue_->bytes_left(), 0U) << "the queue is open";
  ChunkSlot* const borrowed = queue_->take().slot;
  arrive(1);
  queue_->close();
  arrive(1);
  EXPECT_EQ(queue_->bytes_left(), 2U * chunk_bytes);
  EXPECT_EQ(queue_->drop_oldest(), chunk_bytes);
  EXPECT_EQ(queue_->bytes_left(), chunk_bytes);
  ChunkSlot* const last = queue_->take().slot;
  ASSERT_NE(last, nullptr);
  EXPECT_EQ(queue_->bytes_left(), 0U);
  queue_->give_back(*borrowed);
  queue_->give_back(*last);
  EXPECT_EQ(in_use(), 1U) << "the one that arrived too late";
}

TEST_F(ChunkQueueTest, WhatIsLeftInAClosedQueueCanBeTakenAfterTheSessionIsLost) {
  arrive(2);
  queue_->close();
  queue_->lose(SessionMember::Loss::now);
  EXPECT_EQ(queue_->left(), 2U);
  EXPECT_EQ(queue_->bytes_left(), 2U * chunk_bytes);
  EXPECT_EQ(take_all(), 2U);
  EXPECT_TRUE(queue_->drained());
}

TEST_F(ChunkQueueTest, OnlySamplesThatArrivedBeforeTheSessionWasLostCanBeTaken) {
  arrive(2);
  ChunkSlot* const slot = queue_->take().slot;
  const auto before = queue_->arrivals();
  queue_->lose(SessionMember::Loss::now);
  arrive(1);
  EXPECT_FALSE(queue_->open());
  EXPECT_TRUE(queue_->some_wait());
  EXPECT_EQ(queue_->left(), 1U);
  EXPECT_EQ(queue_->arrivals(), before);
  EXPECT_EQ(in_use(), 3U);
  queue_->give_back(*slot);
  const ChunkQueue::Taken kept = queue_->take();
  ASSERT_NE(kept.slot, nullptr);
  EXPECT_FALSE(kept.overflowed);
  EXPECT_TRUE(queue_->drained());
  EXPECT_FALSE(queue_->some_wait());
  EXPECT_EQ(queue_->take().slot, nullptr);
  queue_->give_back(*kept.slot);
  EXPECT_EQ(in_use(), 3U) << "iceoryx is not used any more";
}

TEST_F(ChunkQueueTest, OfAClosedQueueOnlyWhatHadArrivedByThenIsKeptOnceTheSessionIsLost) {
  arrive(1);
  queue_->close();
  arrive(1);
  queue_->lose(SessionMember::Loss::now);
  EXPECT_EQ(queue_->left(), 1U);
  EXPECT_TRUE(queue_->drop_oldest());
  EXPECT_TRUE(queue_->drained());
  EXPECT_FALSE(queue_->drop_oldest());
}

TEST_F(ChunkQueueTest, OfASessionThatWasLostBeforeNothingIsTouched) {
  arrive(2);
  queue_->lose(SessionMember::Loss::before);
  EXPECT_TRUE(queue_->drained());
  EXPECT_EQ(queue_->take().slot, nullptr);
  EXPECT_EQ(port_->m_chunkReceiverData.m_queue.size(), 2U);
}

TEST_F(ChunkQueueTest, AnOverflowBeforeTheSessionWasLostIsToldWithTheFirstChunkThatWasKept) {
  arrive(3);
  queue_->lose(SessionMember::Loss::now);
  EXPECT_TRUE(queue_->take().overflowed);
  EXPECT_FALSE(queue_->take().overflowed);
}

TEST_F(ChunkQueueTest, AWriterGivesBackTheOldestChunkBeforeItTakesTheLastPlace) {
  QueuePlaces places(*port_, false);
  EXPECT_EQ(places.depth(), queue_capacity - 1);
  deliver(places);
  EXPECT_FALSE(places.has_room());
  deliver(places);
  EXPECT_EQ(in_use(), 1U);
  EXPECT_TRUE(queue_->take().overflowed);
}

TEST_F(ChunkQueueTest, ToMakeRoomWhereThereIsSomeIsNoOverflow) {
  QueuePlaces places(*port_, false);
  deliver(places);
  EXPECT_FALSE(queue_->take().overflowed);
}

TEST_F(ChunkQueueTest, TheLastPlaceOfADeepestQueueIsUsedUnlessItsReaderHasAChunkInHand) {
  QueuePlaces places(*port_, true);
  EXPECT_EQ(places.depth(), queue_capacity);
  deliver(places);
  {
    const ChunkInHand hand(*port_);
    EXPECT_FALSE(places.has_room()) << "the place may be that of the chunk";
  }
  EXPECT_TRUE(places.has_room());
  deliver(places);
  EXPECT_FALSE(places.has_room());
  deliver(places);
  EXPECT_EQ(in_use(), 2U);
  EXPECT_TRUE(queue_->take().overflowed);
}

TEST_F(ChunkQueueTest, RoomThatAWriterHasFoundStaysWhenTheReaderTakesAChunkInHand) {
  QueuePlaces places(*port_, true);
  deliver(places);
  ASSERT_TRUE(places.has_room());
  {
    const ChunkInHand hand(*port_);
    deliver(places);
  }
  EXPECT_EQ(in_use(), 2U);
  EXPECT_FALSE(queue_->take().overflowed);
}

TEST_F(ChunkQueueTest, AWriterGivesBackAsManyChunksAsTheBytesOfTheNextOneNeed) {
  QueuePlaces places(*port_, true);
  deliver(places);
  EXPECT_TRUE(places.has_room(1));
  EXPECT_FALSE(places.has_room(0)) << "one waits";
  deliver(places);
  places.make_room(0);
  EXPECT_EQ(in_use(), 0U) << "the next one waits alone";
  arrive(1);
  const ChunkQueue::Taken taken = queue_->take();
  EXPECT_NE(taken.slot, nullptr);
  EXPECT_TRUE(taken.overflowed);
}

TEST_F(ChunkQueueTest, BytesPushNothingOutWhereNoMoreWaitsThanMay) {
  QueuePlaces places(*port_, true);
  deliver(places);
  places.make_room(1);
  arrive(1);
  EXPECT_EQ(in_use(), 2U);
  EXPECT_FALSE(queue_->take().overflowed);
}

/// No system has as much memory as queues with these capacities would need.
TEST_F(ChunkQueueTest, AForgedCapacityIsNoReasonToReserveMemoryForIt) {
  for (const std::uint64_t forged : {UINT64_MAX, UINT64_MAX / 8, std::uint64_t{1} << 56}) {
    forge_capacity(forged);
    ASSERT_NO_THROW(open_queue()) << forged;
    arrive(2);
    queue_->lose(SessionMember::Loss::now);
    EXPECT_EQ(queue_->left(), 2U) << forged;
    EXPECT_EQ(take_all(), 2U) << "what has arrived is kept all the same";
    forge_capacity(queue_capacity);
  }
}

/// The queue reserves memory when it is opened, because it must not allocate memory after its session is
/// lost.
TEST_F(ChunkQueueTest, NoMoreIsKeptThanTheQueueHadRoomForWhenItWasOpened) {
  constexpr int more = 6;
  ASSERT_TRUE(port_->m_chunkReceiverData.m_queue.setCapacity(more)) << "as another program can do";
  arrive(more);
  queue_->lose(SessionMember::Loss::now);
  EXPECT_EQ(queue_->left(), queue_capacity);
  EXPECT_EQ(take_all(), queue_capacity);
  EXPECT_TRUE(queue_->drained());
}

TEST_F(ChunkQueueTest, AForgedSizeDoesNotKeepMoreThanHasArrived) {
  arrive(1);
  forge_size(UINT64_MAX / 2);
  queue_->lose(SessionMember::Loss::now);
  EXPECT_EQ(queue_->left(), 1U);
  EXPECT_EQ(take_all(), 1U);
  EXPECT_TRUE(queue_->drained());
}

TEST_F(ChunkQueueTest, AClosedQueueHasNoMoreThanItsPlacesWhateverItsSizeSays) {
  arrive(1);
  forge_size(UINT64_MAX);
  queue_->close();
  EXPECT_LE(queue_->left(), queue_->capacity());
  EXPECT_LE(queue_->arrivals(), queue_->capacity());
}

TEST_F(ChunkQueueTest, AForgedSizeWhenItWasClosedDoesNotKeepMoreThanHasArrived) {
  arrive(2);
  forge_size(UINT64_MAX / 2);
  queue_->close();
  queue_->lose(SessionMember::Loss::now);
  EXPECT_EQ(take_all(), 2U);
  EXPECT_FALSE(queue_->drop_oldest());
}

}  // namespace
}  // namespace sft::shm
