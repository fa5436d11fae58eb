// The sample buffers of a port, one for each chunk that can be in use at a time. The buffers are made once,
// so that lending a chunk allocates no memory.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <utility>

#include "core/seam/sample_buffer.h"
#include "shm_transport/host/iceoryx.h"

namespace sft::shm {

// iceoryx passes chunks on, and counts their references, with atomics that do not order the contents of the
// chunks. On a CPU that reorders memory accesses, the last loads of a reader could happen after the chunk
// was given back and written anew. So our code has a fence before each call that gives a chunk away, and a
// fence after each call that gets a chunk. (GCC warns that its thread sanitizer ignores fences. The
// sanitizer ignores other processes, too, so the warning can be disabled.)
#ifndef __clang__
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wtsan"
#endif
inline void before_chunk_leaves() noexcept { std::atomic_thread_fence(std::memory_order_release); }
inline void after_chunk_came() noexcept { std::atomic_thread_fence(std::memory_order_acquire); }
#ifndef __clang__
#pragma GCC diagnostic pop
#endif

struct ChunkSlot {
  core::SampleBuffer buffer;
  iox::mepoo::ChunkHeader* chunk = nullptr;
  /// Refers to the chunk of a writer, but is not counted as a reference to the chunk. Counted references
  /// are made from this one.
  iox::mepoo::ShmSafeUnmanagedChunk name{};
  bool sent = false;  ///< true if the writer has sent the chunk, which must not be written any more
  ChunkSlot* next_free = nullptr;

  static ChunkSlot& of(core::SampleBuffer& buffer) { return *static_cast<ChunkSlot*>(buffer.owner_data); }
};

/// The class is not thread-safe: the mutex of the port guards it.
class ChunkSlots {
 public:
  ChunkSlots(std::uint32_t count, const FieldMask& mask) : slots_(std::make_unique<ChunkSlot[]>(count)) {
    for (std::uint32_t i = 0; i < count; ++i) {
      slots_[i].buffer.mask = mask;
      slots_[i].buffer.owner_data = &slots_[i];
      slots_[i].next_free = std::exchange(free_, &slots_[i]);
    }
  }

  bool empty() const { return free_ == nullptr; }
  bool all_back() const { return out_ == 0; }
  std::uint32_t out() const { return out_; }

  ChunkSlot* take() noexcept {
    ChunkSlot* slot = free_;
    if (slot == nullptr) return nullptr;
    free_ = slot->next_free;
    ++out_;
    return slot;
  }

  void give_back(ChunkSlot& slot) noexcept {
    slot.chunk = nullptr;
    slot.next_free = std::exchange(free_, &slot);
    --out_;
  }

 private:
  std::unique_ptr<ChunkSlot[]> slots_;
  ChunkSlot* free_ = nullptr;
  std::uint32_t out_ = 0;
};

}  // namespace sft::shm
