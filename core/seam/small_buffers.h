// The memory of small buffers. Buffers of one size lie beside each other in mapped blocks, and a block
// returns to the system with its last buffer. An allocator of the C library would keep the memory of a peak,
// as long as anything else lies above it in the heap. Trimming that heap would hold up all threads of the
// program, and take the program's own freed memory from it.
#pragma once

#include <array>
#include <cstddef>

#include "core/sync/mutex.h"

namespace sft::core {

/// Any thread may call the functions. All buffers must be given back before the destructor.
class SmallBuffers {
 public:
  static constexpr std::size_t kinds = 5;                ///< the number of different sizes
  static constexpr std::size_t alignment = 64;           ///< of each buffer, if all sizes are multiples of it
  static constexpr std::size_t block_bytes = 64 * 1024;  ///< a multiple of each page size of Linux

  SmallBuffers() = default;
  SmallBuffers(const SmallBuffers&) = delete;
  SmallBuffers& operator=(const SmallBuffers&) = delete;

  /// Returns a buffer of `bytes` bytes; null if there is no memory. `kind` is the number of that size.
  std::byte* take(std::size_t kind, std::size_t bytes) noexcept;
  void give_back(std::byte* buffer) noexcept;

 private:
  struct Block;
  void link(Block& block) noexcept SFT_REQUIRES(mutex_);
  void unlink(Block& block) noexcept SFT_REQUIRES(mutex_);
  std::byte* take_from(Block& block) noexcept SFT_REQUIRES(mutex_);

  Mutex mutex_;  ///< held for a few instructions, never during a system call
  /// For each kind, the first of the blocks that have room for another buffer. Null: there is none.
  std::array<Block*, kinds> with_room_ SFT_GUARDED_BY(mutex_){};
};

}  // namespace sft::core
