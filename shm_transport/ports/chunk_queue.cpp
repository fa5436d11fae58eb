#include "shm_transport/ports/chunk_queue.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "shm_transport/host/chunk_hand.h"

namespace sft::shm {

using iox::mepoo::ShmSafeUnmanagedChunk;

ChunkQueue::Taken ChunkQueue::take() noexcept {
  const core::Lock lock(mutex_);
  if (!open_ && remaining() == 0) return {};
  if (slots_.empty()) {
    if (at_limit_ || (open_ && !port_.hasNewChunks())) return {};
    at_limit_ = true;
    return {.limit_reached = true};
  }
  iox::mepoo::ChunkHeader* const chunk = pop();
  if (chunk == nullptr) return {};
  ChunkSlot* slot = slots_.take();
  slot->chunk = chunk;
  return {.slot = slot, .overflowed = std::exchange(overflow_is_unreported_, false), .popped = ++popped_};
}

/// Returns the number of waiting samples. The result is checked, because other programs can write the
/// number that iceoryx keeps.
std::uint64_t ChunkQueue::waiting() const noexcept {
  return std::min<std::uint64_t>(data_.m_chunkReceiverData.m_queue.size(), kept_.capacity());
}

/// Returns the number of samples that can still be taken from a queue that is not open.
std::uint64_t ChunkQueue::remaining() const noexcept { return kept_.size() - kept_taken_ + arrived_; }

/// Returns the oldest chunk, which is not in the queue any more; null if there is none.
iox::mepoo::ChunkHeader* ChunkQueue::pop() noexcept {
  if (kept_taken_ < kept_.size()) return kept_[kept_taken_++];
  if (!open_) --arrived_;
  return get();
}

/// Borrows the oldest chunk of the queue; null if the queue is empty.
iox::mepoo::ChunkHeader* ChunkQueue::get() noexcept {
  const ChunkInHand hand(data_);
  // The overflow is queried before the chunk is taken, because an overflow after that may concern samples
  // that follow this chunk.
  overflow_is_unreported_ |= port_.hasLostChunksSinceLastCall();
  auto chunk = port_.tryGetChunk();
  return chunk.has_error() ? nullptr : const_cast<iox::mepoo::ChunkHeader*>(chunk.value());
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

bool ChunkQueue::some_wait() const noexcept {
  const core::Lock lock(mutex_);
  return open_ ? port_.hasNewChunks() : remaining() > 0;
}

/// Returns the number of samples that were taken, plus the number of samples that wait. A sample that
/// arrives in a full queue does not change this sum, so the number of overflows is added.
std::uint64_t ChunkQueue::arrivals() noexcept {
  const core::Lock lock(mutex_);
  if (!open_) return popped_ + overflows_ + remaining();
  if (port_.hasLostChunksSinceLastCall()) {
    overflow_is_unreported_ = true;
    ++overflows_;
  }
  return popped_ + overflows_ + waiting();
}

bool ChunkQueue::open() const noexcept {
  const core::Lock lock(mutex_);
  return open_;
}

bool ChunkQueue::drained() const noexcept {
  const core::Lock lock(mutex_);
  return !open_ && remaining() == 0;
}

void ChunkQueue::close() noexcept {
  const core::Lock lock(mutex_);
  if (!std::exchange(open_, false)) return;
  // The writer continues to deliver until the daemon has disconnected it, so only the samples that wait now
  // are counted.
  arrived_ = waiting();
  keep_arrived();
  port_.unsubscribe();
}

/// Takes the chunks that have arrived out of the queue, up to the number that iceoryx lets a reader hold. The
/// size of a chunk in a queue is not known.
void ChunkQueue::keep_arrived() noexcept {
  while (arrived_ > 0 && slots_.out() + kept_.size() < iox::MAX_CHUNKS_HELD_PER_SUBSCRIBER_SIMULTANEOUSLY) {
    iox::mepoo::ChunkHeader* const chunk = get();
    if (chunk == nullptr) {
      arrived_ = 0;
      return;
    }
    --arrived_;
    kept_.push_back(chunk);
  }
}

std::uint64_t ChunkQueue::left() const noexcept {
  const core::Lock lock(mutex_);
  return open_ ? 0 : remaining();
}

std::uint64_t ChunkQueue::bytes_left() const noexcept {
  const core::Lock lock(mutex_);
  return std::accumulate(kept_.begin() + static_cast<std::ptrdiff_t>(kept_taken_), kept_.end(),
                         std::uint64_t{0}, [](std::uint64_t bytes, const iox::mepoo::ChunkHeader* chunk) {
                           return bytes + chunk->userPayloadSize();
                         });
}

std::optional<std::uint64_t> ChunkQueue::drop_oldest() noexcept {
  const core::Lock lock(mutex_);
  if (open_ || remaining() == 0) return std::nullopt;
  const std::uint64_t bytes = kept_taken_ < kept_.size() ? kept_[kept_taken_]->userPayloadSize() : 0;
  // If too many chunks are held already, iceoryx itself gives the chunk back.
  iox::mepoo::ChunkHeader* const chunk = pop();
  if (lost_ || chunk == nullptr) return bytes;
  const ChunkInHand hand(data_);
  port_.releaseChunk(chunk);
  return bytes;
}

void ChunkQueue::lose(SessionMember::Loss loss) noexcept {
  const core::Lock lock(mutex_);
  if (std::exchange(lost_, true)) return;
  const bool was_open = std::exchange(open_, false);
  if (loss == SessionMember::Loss::before) return;
  std::uint64_t arrived = was_open ? waiting() : std::exchange(arrived_, 0);
  overflow_is_unreported_ |= port_.hasLostChunksSinceLastCall();
  iox::popo::ChunkQueuePopper<iox::popo::SubscriberPortData::ChunkQueueData_t> popper(
      &data_.m_chunkReceiverData);
  for (; arrived > 0; --arrived) {
    // The reference is never given back: a writer that has not noticed the loss of the session must not
    // lend the chunk anew.
    if (auto chunk = popper.tryPop())
      kept_.push_back(ShmSafeUnmanagedChunk(std::move(*chunk)).getChunkHeader());
  }
}

}  // namespace sft::shm
