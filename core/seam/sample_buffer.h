// The memory of one encoded sample, whoever lends it: a chunk in shared memory, a reassembly buffer, a heap
// buffer. Handles share it; when the last one goes, it returns to its owner, which each buffer that is out
// keeps alive.
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
  /// Called once the last handle is gone, on that handle's thread.
  virtual void recycle(SampleBuffer& buffer) noexcept = 0;
};

/// Filled by the owner when it hands the buffer out, but for `elements`, which is then empty. Ports of
/// readers set the origin once they have checked the header, and publishers set it.
struct SampleBuffer : SampleOrigin {
  std::byte* data = nullptr;  ///< 8-aligned; begins with a SampleHeader
  std::size_t capacity = 0;
  FieldMask mask;                     ///< leaves that the sample has
  std::uint64_t parts = 0;            ///< of some only a part: Selection::parts_hash(); 0: all are whole
  detail::ElementIndex elements;      ///< what readers found out about this sample
  std::int64_t receive_stamp_ns = 0;  ///< CLOCK_REALTIME; 0 on the sending side
  /// On the sending side, for what is counted as saved: of the body with all fields; 0: unknown.
  std::uint32_t whole_bytes = 0;
  /// On the sending side, while publish() runs: what of the body is still in the program's own memory; null:
  /// nothing.
  detail::PostponedCopies* postponed = nullptr;
  std::shared_ptr<BufferOwner> owner;
  void* owner_data = nullptr;  ///< the owner's own
  std::atomic<std::uint32_t> references{0};

  detail::SampleHeader& header() const { return *reinterpret_cast<detail::SampleHeader*>(data); }
  /// Takes over what the header says, which only this process can write so far.
  void trust_header() noexcept { trust(header()); }
  SampleOrigin& origin() noexcept { return *this; }
  /// Before anybody else sees the body, or publish() returns.
  void complete() noexcept {
    if (detail::PostponedCopies* const copies = std::exchange(postponed, nullptr)) copies->make_all();
  }
  std::uint32_t* index() const {
    return reinterpret_cast<std::uint32_t*>(data + sizeof(detail::SampleHeader));
  }
};

/// The state that getters and projections read, of a sample with so many slots. Every process of the host can
/// write a header in shared memory, also after it was checked. Therefore the beginning of the body is not
/// read from there, and the body is bounded by the buffer. The state does not have the buffer's `elements`,
/// which belong to a reader.
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
  /// Takes one reference.
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
    const std::shared_ptr<BufferOwner> owner = std::move(buffer->owner);  // may be the owner's last reference
    owner->recycle(*buffer);
  }

  /// Nobody else has one of it, nor sees any more what others did with theirs.
  bool is_only() const noexcept { return buffer_->references.load(std::memory_order_acquire) == 1; }

  /// Gives the reference away, and takes over one that was given away.
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
