#include "shm_transport/ports/chunk_queue.h"

#include <utility>

#include "shm_transport/host/chunk_hand.h"

namespace sft::shm {

ChunkQueue::Taken ChunkQueue::take() noexcept {
  const core::Lock lock(mutex_);
  if (lost_ || (!open_ && arrived_ == 0)) return {};
  if (slots_.empty()) {
    if (at_limit_ || !port_.hasNewChunks()) return {};
    at_limit_ = true;
    return {.limit_reached = true};
  }
  if (!open_) --arrived_;
  const ChunkInHand hand(data_);
  // The overflow is queried before the chunk is taken, because a later overflow may concern samples behind
  // this one.
  overflow_is_news_ |= port_.hasLostChunksSinceLastCall();
  auto chunk = port_.tryGetChunk();
  if (chunk.has_error()) return {};
  ChunkSlot* slot = slots_.take();
  slot->chunk = const_cast<iox::mepoo::ChunkHeader*>(chunk.value());
  return {.slot = slot, .overflowed = std::exchange(overflow_is_news_, false), .popped = ++popped_};
}

void ChunkQueue::give_back(ChunkSlot& slot) noexcept {
  const core::Lock lock(mutex_);
  if (!lost_) {
    const ChunkInHand hand(data_);
    port_.releaseChunk(slot.chunk);
  }
  slots_.give_back(slot);
  at_limit_ = false;
}

/// Counts the samples that were taken and those that wait. When the queue is full, this sum does not change
/// any more, so overflows are counted, too.
std::uint64_t ChunkQueue::arrivals() noexcept {
  const core::Lock lock(mutex_);
  if (lost_) return popped_ + overflows_;
  if (port_.hasLostChunksSinceLastCall()) {
    overflow_is_news_ = true;
    ++overflows_;
  }
  return popped_ + overflows_ + data_.m_chunkReceiverData.m_queue.size();
}

bool ChunkQueue::open() const noexcept {
  const core::Lock lock(mutex_);
  return open_;
}

bool ChunkQueue::drained() const noexcept {
  const core::Lock lock(mutex_);
  return lost_ || (!open_ && arrived_ == 0);
}

void ChunkQueue::close() noexcept {
  const core::Lock lock(mutex_);
  if (!std::exchange(open_, false)) return;
  // The writer goes on delivering until the daemon has disconnected it, so only the samples of now are
  // counted.
  arrived_ = data_.m_chunkReceiverData.m_queue.size();
  port_.unsubscribe();
}

std::uint64_t ChunkQueue::left() const noexcept {
  const core::Lock lock(mutex_);
  return lost_ ? 0 : arrived_;
}

bool ChunkQueue::drop_oldest() noexcept {
  const core::Lock lock(mutex_);
  if (lost_ || arrived_ == 0) return false;
  --arrived_;
  const ChunkInHand hand(data_);
  // If too many chunks are held already, iceoryx gives this one back itself.
  if (auto chunk = port_.tryGetChunk(); !chunk.has_error()) port_.releaseChunk(chunk.value());
  return true;
}

void ChunkQueue::lose() noexcept {
  const core::Lock lock(mutex_);
  open_ = false;
  lost_ = true;
}

}  // namespace sft::shm
