// Heap memory for samples: what publishers encode into when nobody on this host reads, and what datagrams are
// put together in. Buffers are kept by power-of-two size and reused, so that in steady state nothing is
// allocated.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

#include "core/sample_buffer.h"

namespace sft::core {

class BufferPool final : public BufferOwner, public std::enable_shared_from_this<BufferPool> {
 public:
  /// At most `limit_bytes` are handed out and kept at a time.
  static std::shared_ptr<BufferPool> make(std::size_t limit_bytes);
  ~BufferPool() override;

  /// A buffer of at least `bytes` with a fresh SampleHeader; empty at the limit or without memory. Any
  /// thread.
  SampleHandle take(std::size_t bytes) noexcept;

  void recycle(SampleBuffer& buffer) noexcept override;

 private:
  static constexpr std::size_t min_shift = 9;  // 512 bytes
  static constexpr std::size_t classes = 18;   // up to 64 MiB
  explicit BufferPool(std::size_t limit_bytes) : limit_bytes_(limit_bytes) {}
  SampleBuffer* make_buffer(std::size_t capacity) noexcept;
  void shrink(std::size_t needed) noexcept;

  std::mutex mutex_;  // held for a few instructions, never over an allocation
  std::array<std::vector<SampleBuffer*>, classes> free_;
  std::size_t held_bytes_ = 0;
  std::size_t limit_bytes_;
};

}  // namespace sft::core
