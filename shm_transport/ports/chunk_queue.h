// The queue of chunks that one writer fills for a reader, and the chunks that are borrowed from the queue.
// The number of chunks that are borrowed at a time is limited. After the queue is closed or lost, the
// samples that arrived before that can still be taken. After the queue is lost, iceoryx is not used any
// more.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/sync/lock_order.h"
#include "core/sync/mutex.h"
#include "shm_transport/host/chunk_slots.h"
#include "shm_transport/host/iceoryx.h"
#include "shm_transport/host/session_member.h"

namespace sft::shm {

/// Any thread may call the functions, but only one thread at a time may take or drop chunks.
class ChunkQueue {
 public:
  /// `port` must outlive the queue. `most` is the maximum number of chunks that may be borrowed at a time.
  ChunkQueue(iox::popo::SubscriberPortData& port, std::uint32_t most, const FieldMask& mask)
      : data_(port), port_(&port), slots_(most, mask) {
    // The capacity is limited, because it is in shared memory, where other programs can write.
    kept_.reserve(std::min<std::size_t>(capacity(), iox::MAX_SUBSCRIBER_QUEUE_CAPACITY));
  }

  iox::popo::SubscriberPortData& port() const noexcept { return data_; }
  std::uint64_t capacity() const noexcept { return data_.m_chunkReceiverData.m_queue.capacity(); }

  struct Taken {
    ChunkSlot* slot = nullptr;  ///< the slot with the chunk; null: there is no chunk, or the limit is reached
    bool overflowed = false;    ///< true if samples between the chunk taken last and this chunk were lost
    /// True if a chunk waits that cannot be borrowed, because the limit of borrowed chunks is reached.
    /// Reported once until a chunk is given back.
    bool limit_reached = false;
    std::uint64_t popped = 0;  ///< number of chunks taken so far
  };
  /// Borrows the oldest chunk if a slot is free for it. Otherwise the chunk stays in the queue, which may
  /// overflow. iceoryx itself would drop a chunk that exceeds its limit of held chunks.
  Taken take() noexcept;
  void give_back(ChunkSlot& slot) noexcept;

  /// Returns whether a chunk waits, even if no slot is free for it.
  bool some_wait() const noexcept;
  /// Returns a number that changes whenever a sample has arrived.
  std::uint64_t arrivals() noexcept;

  bool open() const noexcept;     ///< true if the queue is neither closed nor lost
  bool drained() const noexcept;  ///< true if the queue is not open, and no sample remains to be taken
  void close() noexcept;
  /// Returns the number of samples that remain to be taken after close() or lose(); 0 before these calls.
  std::uint64_t left() const noexcept;
  /// Returns the bytes of these samples, except for those that iceoryx does not lend because the reader holds
  /// too many.
  std::uint64_t bytes_left() const noexcept;
  /// Drops the oldest of the samples that remain after close() or lose(). Returns its part of bytes_left();
  /// nothing if no sample remains.
  std::optional<std::uint64_t> drop_oldest() noexcept;
  /// Notes that the session is lost. The samples that have arrived stay mapped, and their memory is not
  /// lent anew, because this reader never gives it back.
  void lose(SessionMember::Loss loss) noexcept;

 private:
  std::uint64_t waiting() const noexcept SFT_REQUIRES(mutex_);
  std::uint64_t remaining() const noexcept SFT_REQUIRES(mutex_);
  iox::mepoo::ChunkHeader* pop() noexcept SFT_REQUIRES(mutex_);
  iox::mepoo::ChunkHeader* get() noexcept SFT_REQUIRES(mutex_);
  void keep_arrived() noexcept SFT_REQUIRES(mutex_);

  iox::popo::SubscriberPortData& data_;
  mutable core::Mutex mutex_ SFT_ACQUIRED_AFTER(core::lock_order::jobs);  ///< never held over a system call
  iox::popo::SubscriberPortUser port_ SFT_GUARDED_BY(mutex_);
  ChunkSlots slots_ SFT_GUARDED_BY(mutex_);
  bool open_ SFT_GUARDED_BY(mutex_) = true;  ///< true if the queue is neither closed nor lost
  /// True if the session is lost, and iceoryx must not be used any more.
  bool lost_ SFT_GUARDED_BY(mutex_) = false;
  /// The number of samples that had arrived at close(), are not in `kept_`, and are not yet taken.
  std::uint64_t arrived_ SFT_GUARDED_BY(mutex_) = 0;
  /// The chunks that had arrived at close() or lose(), of which the first `kept_taken_` are taken. Before
  /// lose(), the port counts them as borrowed.
  std::vector<iox::mepoo::ChunkHeader*> kept_ SFT_GUARDED_BY(mutex_);
  std::size_t kept_taken_ SFT_GUARDED_BY(mutex_) = 0;
  std::uint64_t popped_ SFT_GUARDED_BY(mutex_) = 0;     ///< number of chunks taken out of the queue
  std::uint64_t overflows_ SFT_GUARDED_BY(mutex_) = 0;  ///< number of overflows that arrivals() has noticed
  /// True if an overflow was noticed, and take() has not reported it.
  bool overflow_is_unreported_ SFT_GUARDED_BY(mutex_) = false;
  /// True if the limit of borrowed chunks is reached, and take() has reported it.
  bool at_limit_ SFT_GUARDED_BY(mutex_) = false;
};

}  // namespace sft::shm
