// The places of a queue between a writer and a reader.
//
// The places of a queue of iceoryx have numbers. A reader that takes a chunk has the number of its place in
// hand for some instructions. If the reader stops there, or is killed, the queue has one place less. A push
// into a full queue would then never end: it waits for a free place, or until all places have a chunk, and
// neither happens. So a queue has one place more than the number of samples that may wait in it, and a
// writer makes room itself before it pushes into a queue with that number of samples. The reader has at
// most one place in hand, because it takes one chunk at a time. No other writer has one, because each queue
// has one writer.
//
// The deepest queue has no spare place, because iceoryx has no larger queue. Its last place is used only
// while the reader has no chunk in hand (chunk_hand.h).
#pragma once

#include <algorithm>
#include <cstdint>

#include "shm_transport/host/chunk_hand.h"
#include "shm_transport/host/iceoryx.h"
#include "shm_transport/host/queue_room.h"
#include "shm_transport/host/waiting_bytes.h"

namespace sft::shm {

class QueuePlaces {
 public:
  using Queue = iox::popo::SubscriberPortData::ChunkQueueData_t;

  /// The greatest number of samples that can wait in a queue. A queue of this depth is called a deepest
  /// one.
  static constexpr std::uint32_t depth_max = iox::MAX_SUBSCRIBER_QUEUE_CAPACITY;
  /// Returns the capacity of a queue in which `depth` samples can wait.
  static constexpr std::uint64_t capacity_for(std::uint32_t depth) noexcept {
    return std::clamp(depth, 1U, depth_max - 1) + 1;
  }

  /// `port` has the queue, and must outlive this object. `is_deepest` is true if the reader's requests say
  /// so (QueueWishes).
  QueuePlaces(iox::popo::SubscriberPortData& port, bool is_deepest) noexcept
      : port_(&port), is_deepest_(is_deepest) {}
  /// Makes an object without a queue. Its only use is to be assigned to.
  QueuePlaces() noexcept = default;

  const iox::popo::SubscriberPortData& port() const noexcept { return *port_; }

  /// Returns the number of samples that can wait. The result is checked, because other programs can write
  /// the number that iceoryx keeps.
  std::uint64_t depth() const noexcept {
    const std::uint64_t capacity = queue().m_queue.capacity();
    return is_deepest_ || capacity < 2 ? capacity : capacity - 1;
  }

  /// Returns whether another sample can wait without a loss. Called by the writer. Room that was found
  /// stays until the writer pushes, because the reader only takes chunks, and the place of the chunk that
  /// it takes next is a different one. So the queue is not read again until then. Reading it would move its
  /// words from the reader's processor once more.
  ///
  /// `beside` is the number of chunks that may wait beside the next one, because their bytes are limited
  /// (waiting_bytes.h).
  bool has_room(std::uint64_t beside = WaitingBytes::any_number) noexcept {
    if (free_ == 0) free_ = free_places();
    return free_ != 0 && !waits_more_than(beside);
  }

  /// Gives back the oldest chunks if the queue has no room. Called by the writer before it pushes one
  /// chunk. The reader then notices that its queue has overflowed.
  void make_room(std::uint64_t beside = WaitingBytes::any_number) noexcept {
    if (has_room()) {
      --free_;
    } else {
      drop_oldest();
    }
    while (waits_more_than(beside) && drop_oldest()) {
    }
  }

 private:
  /// Returns whether more than `beside` chunks wait. Does not read the queue if any number may wait.
  bool waits_more_than(std::uint64_t beside) const noexcept {
    return beside < depth_max && queue().m_queue.size() > beside;
  }

  /// Gives back the oldest chunk. Returns false if the reader has taken all chunks meanwhile.
  bool drop_oldest() noexcept {
    if (!iox::popo::ChunkQueuePopper<Queue>(&queue()).tryPop()) return false;
    iox::popo::ChunkQueuePusher<Queue>(&queue()).lostAChunk();
    return true;
  }

  Queue& queue() const noexcept { return port_->m_chunkReceiverData; }

  std::uint64_t free_places() const noexcept {
    const std::uint64_t waiting = queue().m_queue.size();
    const std::uint64_t places = std::min<std::uint64_t>(queue().m_queue.capacity(), depth_max);
    if (waiting + 1 < places) return places - 1 - waiting;
    if (!is_deepest_ || waiting >= places) return 0;
    full_fence();  // if the reader has no place in hand after `waiting` was counted, a place is free
    return is_in_hand(*port_) ? 0 : 1;
  }

  iox::popo::SubscriberPortData* port_ = nullptr;
  bool is_deepest_ = false;
  std::uint64_t free_ = 0;  ///< number of chunks that can be pushed before the queue has to be read
};

}  // namespace sft::shm
