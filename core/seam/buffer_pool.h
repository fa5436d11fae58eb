// Heap memory for samples. Publishers encode into this memory while no reader on this host uses shared
// memory, and the receiver assembles samples from datagrams in it. Buffers are kept by size and reused, so
// that in steady state nothing is allocated. The sizes are a little greater than powers of two. So a body
// whose size is a power of two fits together with its header and index, and does not need a buffer of twice
// the size.
#pragma once

#include <array>
#include <bitset>
#include <chrono>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "core/platform/clock.h"
#include "core/seam/sample_buffer.h"
#include "core/seam/small_buffers.h"
#include "core/sync/lock_order.h"
#include "core/sync/mutex.h"

namespace sft::core {

class BufferPool final : public BufferOwner, public std::enable_shared_from_this<BufferPool> {
 public:
  /// Makes a pool whose lent and kept buffers have at most `limit_bytes` bytes together.
  static std::shared_ptr<BufferPool> make(std::size_t limit_bytes);
  ~BufferPool() override;

  /// Returns a buffer of at least `bytes` with a new SampleHeader. The handle is empty if there is no
  /// memory, or if fewer than `leave_bytes` bytes of the pool's limit would remain for other callers. Any
  /// thread may call this.
  SampleHandle take(std::size_t bytes, std::size_t leave_bytes = 0) noexcept;

  /// Takes up to `count` of the buffers for `bytes` bytes that the pool keeps unused at present, and
  /// appends them to `buffers`. At least `leave_bytes` bytes of the pool's limit remain for other callers.
  /// Any thread may call this.
  void take_kept(std::size_t bytes, std::size_t leave_bytes, std::size_t count,
                 std::vector<SampleHandle>& buffers);

  /// Notes that buffers of at least `bytes` bytes may be needed soon, so that stock() prepares some. Any
  /// thread may call this.
  void expect(std::size_t bytes) noexcept;
  /// Prepares two buffers of each large size that was expected since the last call, and touches their
  /// memory. (The system allocates pages at their first use, which takes longer than a copy, on some
  /// machines many times as long.) Must be called now and then, by a thread for which no other thread
  /// waits.
  void stock() noexcept;

  /// Returns kept buffers to the system that were unused during the whole last period, for example after a
  /// peak of load. Must be called now and then, by a thread for which no other thread waits.
  void give_back(Time now) noexcept;
  static constexpr std::chrono::seconds period{10};

  std::size_t limit_bytes() const { return limit_bytes_; }

  void recycle(SampleBuffer& buffer) noexcept override;

 private:
  static constexpr std::size_t classes = 19;
  explicit BufferPool(std::size_t limit_bytes) : limit_bytes_(limit_bytes) {}
  SampleHandle hand_out(SampleBuffer& buffer, std::shared_ptr<BufferOwner> self) noexcept;
  SampleBuffer* make_buffer(std::size_t capacity) noexcept;
  /// Counts `capacity` bytes against the limit. Returns false if the limit would be exceeded.
  bool reserve(std::size_t capacity) noexcept;
  SampleBuffer* make_reserved(std::size_t capacity) noexcept;
  std::byte* allocate(std::size_t capacity) noexcept;
  void release(std::byte* data, std::size_t capacity) noexcept;
  void destroy(std::span<SampleBuffer* const> buffers) noexcept;
  bool stock_one(std::size_t size_class) noexcept;
  SampleBuffer* pick(std::size_t size_class) noexcept SFT_REQUIRES(mutex_);
  void keep(SampleBuffer& buffer) noexcept SFT_REQUIRES(mutex_);
  void shrink(std::size_t needed) noexcept;

  Mutex mutex_ SFT_ACQUIRED_AFTER(lock_order::jobs);  // held for a few instructions, never during an
                                                      // allocation
  std::array<std::vector<SampleBuffer*>, classes> free_ SFT_GUARDED_BY(mutex_);
  /// For each size, the minimum number of unused buffers in the present period.
  std::array<std::size_t, classes> unneeded_ SFT_GUARDED_BY(mutex_){};
  Time period_ends_{};                                    ///< used only by give_back()
  std::bitset<classes> expected_ SFT_GUARDED_BY(mutex_);  ///< the sizes that stock() has to prepare
  std::size_t held_bytes_ SFT_GUARDED_BY(mutex_) = 0;     ///< the size of all buffers in bytes, lent and kept
  std::size_t lent_bytes_ SFT_GUARDED_BY(mutex_) = 0;
  const std::size_t limit_bytes_;
  SmallBuffers small_;
};

}  // namespace sft::core
