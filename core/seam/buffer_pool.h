// Heap memory for samples: what publishers encode into when nobody on this host reads, and what datagrams are
// put together in. Buffers are kept by size and reused, so that in steady state nothing is allocated. The
// sizes are a little over powers of two, so that a round body with its header and index does not take twice
// as much.
#pragma once

#include <array>
#include <bitset>
#include <chrono>
#include <cstddef>
#include <memory>
#include <vector>

#include "core/platform/clock.h"
#include "core/seam/sample_buffer.h"
#include "core/sync/lock_order.h"
#include "core/sync/mutex.h"

namespace sft::core {

class BufferPool final : public BufferOwner, public std::enable_shared_from_this<BufferPool> {
 public:
  /// At most `limit_bytes` are handed out and kept at a time.
  static std::shared_ptr<BufferPool> make(std::size_t limit_bytes);
  ~BufferPool() override;

  /// A buffer of at least `bytes` with a fresh SampleHeader; empty without memory, and where less than
  /// `leave_bytes` of the limit would remain for others. Any thread.
  SampleHandle take(std::size_t bytes, std::size_t leave_bytes = 0) noexcept;

  /// Takes up to `count` of the buffers of that size that the pool keeps at present, and appends them to
  /// `buffers`. Any thread.
  void take_kept(std::size_t bytes, std::size_t leave_bytes, std::size_t count,
                 std::vector<SampleHandle>& buffers);

  /// Buffers of that size may be needed soon: stock() makes some ready. Any thread.
  void expect(std::size_t bytes) noexcept;
  /// Makes two buffers ready of each large size that was expected since the last call. Their memory has been
  /// used once: the system gives memory at its first use, which takes longer than a copy, on some machines
  /// many times. To be called now and then, by a thread for which nobody waits.
  void stock() noexcept;

  /// Gives the system back what was kept and not needed at any moment of the last period, as after a peak of
  /// load. To be called now and then, by a thread for which nobody waits.
  void give_back(Time now) noexcept;
  static constexpr std::chrono::seconds period{30};

  std::size_t limit_bytes() const { return limit_bytes_; }

  void recycle(SampleBuffer& buffer) noexcept override;

 private:
  static constexpr std::size_t classes = 19;
  explicit BufferPool(std::size_t limit_bytes) : limit_bytes_(limit_bytes) {}
  SampleHandle hand_out(SampleBuffer& buffer, std::shared_ptr<BufferOwner> self) noexcept;
  SampleBuffer* make_buffer(std::size_t capacity) noexcept;
  /// False if the limit does not allow it.
  bool reserve(std::size_t capacity) noexcept;
  SampleBuffer* make_reserved(std::size_t capacity) noexcept;
  bool stock_one(std::size_t size_class) noexcept;
  SampleBuffer* pick(std::size_t size_class) noexcept SFT_REQUIRES(mutex_);
  void keep(SampleBuffer& buffer) noexcept SFT_REQUIRES(mutex_);
  void shrink(std::size_t needed) noexcept;

  Mutex mutex_ SFT_ACQUIRED_AFTER(lock_order::jobs);  // held for a few instructions, never over an allocation
  std::array<std::vector<SampleBuffer*>, classes> free_ SFT_GUARDED_BY(mutex_);
  /// The fewest buffers of a size that were kept at any moment of the period.
  std::array<std::size_t, classes> unneeded_ SFT_GUARDED_BY(mutex_){};
  Time period_ends_{};                                    ///< for give_back() alone
  std::bitset<classes> expected_ SFT_GUARDED_BY(mutex_);  ///< sizes that stock() has to look at
  std::size_t held_bytes_ SFT_GUARDED_BY(mutex_) = 0;     ///< lent and kept
  std::size_t lent_bytes_ SFT_GUARDED_BY(mutex_) = 0;
  const std::size_t limit_bytes_;
};

}  // namespace sft::core
