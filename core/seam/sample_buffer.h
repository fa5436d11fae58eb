// The memory of one encoded sample: a chunk in shared memory, a reassembly buffer, or a heap buffer. Several
// handles can share the memory. When the last handle is destroyed, the memory returns to its owner. Each lent
// buffer keeps its owner alive.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>

#include "core/seam/sample_origin.h"
#include "sft/detail/element_index.h"
#include "sft/detail/postponed_copies.h"
#include "sft/detail/sample_format.h"
#include "sft/detail/walk.h"
#include "sft/mask.h"

namespace sft::core {

struct SampleBuffer;

class BufferOwner {
 public:
  virtual ~BufferOwner() = default;
  /// Called when the last handle is destroyed, on the thread that destroys it.
  virtual void recycle(SampleBuffer& buffer) noexcept = 0;
};

/// A buffer and the properties of the sample in it. When the owner lends the buffer, it sets the members,
/// and empties `elements`. Publishers set the origin, and so do ports of readers once they have checked the
/// header.
struct SampleBuffer : SampleOrigin {
  std::byte* data = nullptr;  ///< 8-aligned; begins with a SampleHeader
  std::size_t capacity = 0;
  FieldMask mask;  ///< the leaves that the sample has
  /// Selection::parts_hash() if the sample has only parts of some fields; 0: the sample has all its fields
  /// completely.
  std::uint64_t parts = 0;
  detail::ElementIndex elements;      ///< the positions of elements that readers have found so far
  std::int64_t receive_stamp_ns = 0;  ///< the time of CLOCK_REALTIME at which the sample arrived; 0 on the
                                      ///< sending side
  /// On the sending side: the bytes of the body with all fields, by which the saved bytes are computed; 0:
  /// unknown.
  std::uint32_t whole_bytes = 0;
  /// On the sending side, while publish() runs: the parts of the body that are still in the program's own
  /// memory; null: none.
  detail::PostponedCopies* postponed = nullptr;
  std::shared_ptr<BufferOwner> owner;
  void* owner_data = nullptr;  ///< private data of the owner
  std::atomic<std::uint32_t> references{0};

  detail::SampleHeader& header() const { return *reinterpret_cast<detail::SampleHeader*>(data); }
  /// Copies the origin from the header. Call this only while no other process can write to the header.
  void trust_header() noexcept { trust(header()); }
  SampleOrigin& origin() noexcept { return *this; }
  /// Copies the postponed parts. Must be called before another thread or process reads the body, and before
  /// publish() returns.
  void complete() noexcept {
    if (detail::PostponedCopies* const copies = std::exchange(postponed, nullptr)) copies->make_all();
  }
  std::uint32_t* index() const {
    return reinterpret_cast<std::uint32_t*>(data + sizeof(detail::SampleHeader));
  }
};

/// Returns the state that getters and projections read. `slots` is the number of index slots of the sample's
/// type. Every process of the host can write to a header in shared memory, even after the header was checked.
/// Therefore the beginning of the body is not read from the header, and the body is bounded by the buffer.
/// The state does not have the buffer's `elements`, which belong to a reader.
inline detail::SampleState state_of(const SampleBuffer& buffer, std::size_t slots) noexcept {
  const std::size_t body_offset = detail::SampleLayout(slots).body_offset;
  const std::size_t body_bytes = __atomic_load_n(&buffer.header().body_bytes, __ATOMIC_RELAXED);
  detail::SampleState state;
  state.body = buffer.data + body_offset;
  state.body_bytes = static_cast<std::uint32_t>(std::min(body_bytes, buffer.capacity - body_offset));
  state.index = buffer.index();
  state.mask = &buffer.mask;
  return state;
}

class SampleHandle {
 public:
  SampleHandle() = default;
  /// Makes a handle, which adds one reference to the buffer.
  explicit SampleHandle(SampleBuffer& buffer) : buffer_(&buffer) {
    buffer.references.fetch_add(1, std::memory_order_relaxed);
  }
  SampleHandle(const SampleHandle& other) : buffer_(other.buffer_) {
    if (buffer_ != nullptr) buffer_->references.fetch_add(1, std::memory_order_relaxed);
  }
  SampleHandle(SampleHandle&& other) noexcept : buffer_(std::exchange(other.buffer_, nullptr)) {}
  SampleHandle& operator=(SampleHandle other) noexcept {
    std::swap(buffer_, other.buffer_);
    return *this;
  }
  ~SampleHandle() { reset(); }

  void reset() noexcept {
    SampleBuffer* buffer = std::exchange(buffer_, nullptr);
    if (buffer == nullptr || buffer->references.fetch_sub(1, std::memory_order_acq_rel) != 1) return;
    buffer->elements.clear();
    // May hold the last reference to the owner.
    const std::shared_ptr<BufferOwner> owner = std::move(buffer->owner);
    owner->recycle(*buffer);
  }

  /// Returns true if this is the only handle. In this case all accesses through former handles happen
  /// before the return.
  bool is_only() const noexcept { return buffer_->references.load(std::memory_order_acquire) == 1; }

  /// Releases ownership of the reference. adopt() makes a handle from such a reference.
  [[nodiscard]] SampleBuffer* release() noexcept { return std::exchange(buffer_, nullptr); }
  static SampleHandle adopt(SampleBuffer* buffer) noexcept {
    SampleHandle handle;
    handle.buffer_ = buffer;
    return handle;
  }

  explicit operator bool() const { return buffer_ != nullptr; }
  SampleBuffer* operator->() const { return buffer_; }
  SampleBuffer& operator*() const { return *buffer_; }

 private:
  SampleBuffer* buffer_ = nullptr;
};

}  // namespace sft::core
