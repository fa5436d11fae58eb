// The places of a queue between a writer and a reader.
//
// A queue of iceoryx stores each chunk in a place, and the places have numbers. While a reader takes a
// chunk, the reader holds the number of the chunk's place for some instructions. If the reader stops or is
// killed then, the queue has one place less. A push into a full queue would then never end: it waits until
// a place is free or all places have a chunk, and neither happens. So a queue has one place more than the
// number of samples that may wait in it, and a writer removes the oldest chunk itself before it pushes into
// a queue with that number of samples. The reader holds at most one place, because it takes one chunk at a
// time. No other writer holds a place, because each queue has one writer.
//
// A queue of the maximum depth has no such spare place, because iceoryx has no larger queue. Its last place
// is used only while the reader has no chunk in hand (chunk_hand.h).
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

  /// The maximum number of samples that can wait in a queue. A queue of this depth is called deepest.
  static constexpr std::uint32_t depth_max = iox::MAX_SUBSCRIBER_QUEUE_CAPACITY;
  /// Returns the capacity of a queue in which `depth` samples can wait.
  static constexpr std::uint64_t capacity_for(std::uint32_t depth) noexcept {
    return std::clamp(depth, 1U, depth_max - 1) + 1;
  }

  /// `port` has the queue, and must outlive this object. `is_deepest` is QueueWishes::deepest of the
  /// reader.
  QueuePlaces(iox::popo::SubscriberPortData& port, bool is_deepest) noexcept
      : port_(&port), is_deepest_(is_deepest) {}
  /// Makes an object without a queue. Its only use is to be assigned to.
  QueuePlaces() noexcept = default;

  const iox::popo::SubscriberPortData& port() const noexcept { return *port_; }

  /// Returns the maximum number of samples that can wait in the queue. The result is checked, because other
  /// programs can write the number that iceoryx keeps.
  std::uint64_t depth() const noexcept {
    const std::uint64_t capacity = queue().m_queue.capacity();
    return is_deepest_ || capacity < 2 ? capacity : capacity - 1;
  }

  /// Returns whether one more sample can be pushed without the loss of a waiting sample. Called by the
  /// writer. A free place that was found stays free until the writer pushes, because the reader only takes
  /// chunks, and takes them from other places. So the queue is not read again until then. Reading the queue
  /// would move its words from the reader's processor once more.
  ///
  /// `beside` is the maximum number of chunks that may wait together with the next chunk. It follows from
  /// the limit of the waiting bytes (waiting_bytes.h).
  bool has_room(std::uint64_t beside = WaitingBytes::any_number) noexcept {
    if (free_ == 0) free_ = free_places();
    return free_ != 0 && !waits_more_than(beside);
  }

  /// Gives back the oldest chunks if one more chunk has no room in the queue. Called by the writer before
  /// it pushes that chunk. The reader then notices that its queue has overflowed.
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
  /// Returns whether more than `beside` chunks wait. Does not read the queue if `beside` sets no limit.
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
    full_fence();  // a place is free unless the reader has had one in hand since `waiting` was read
    return is_in_hand(*port_) ? 0 : 1;
  }

  iox::popo::SubscriberPortData* port_ = nullptr;
  bool is_deepest_ = false;
  /// Number of chunks that can be pushed before the state of the queue has to be read again.
  std::uint64_t free_ = 0;
};

}  // namespace sft::shm
