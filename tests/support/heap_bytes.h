// The memory that an allocator has given out, by which tests find what is kept for ever.
#pragma once

#include <malloc.h>

#include <cstddef>

namespace sft::test {

/// Returns the bytes that all threads have allocated and not freed. Under a sanitizer, which has an allocator
/// of its own, the number does not change.
inline std::ptrdiff_t heap_bytes() {
  const struct mallinfo2 heap = mallinfo2();
  return static_cast<std::ptrdiff_t>(heap.uordblks + heap.hblkhd);
}

/// Returns how many bytes ten thousand rounds leave behind. A hundred rounds before them allocate what is
/// used again.
template <class Round>
std::ptrdiff_t bytes_left_by(Round round) {
  for (int i = 0; i < 100; ++i) round();
  const std::ptrdiff_t before = heap_bytes();
  for (int i = 0; i < 10'000; ++i) round();
  return heap_bytes() - before;
}

/// Ten thousand rounds leave more than these bytes if each of them leaves the smallest block.
inline constexpr std::ptrdiff_t nothing_left = 10'000;

}  // namespace sft::test
