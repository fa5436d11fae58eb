// Measures allocated memory, so that tests can find memory that is never freed.
#pragma once

#include <malloc.h>

#include <cstddef>

namespace sft::test {

/// Returns the number of bytes that all threads have allocated and not freed. Under a sanitizer, which has
/// its own allocator, the number does not change.
inline std::ptrdiff_t heap_bytes() {
  const struct mallinfo2 heap = mallinfo2();
  return static_cast<std::ptrdiff_t>(heap.uordblks + heap.hblkhd);
}

/// Calls `round` ten thousand times, and returns the number of bytes that these rounds have allocated and
/// not freed. A hundred earlier rounds allocate the memory that later rounds reuse.
template <class Round>
std::ptrdiff_t bytes_left_by(Round round) {
  for (int i = 0; i < 100; ++i) round();
  const std::ptrdiff_t before = heap_bytes();
  for (int i = 0; i < 10'000; ++i) round();
  return heap_bytes() - before;
}

/// The limit for bytes_left_by(). If each round leaves only the smallest block, ten thousand rounds leave
/// more bytes.
inline constexpr std::ptrdiff_t nothing_left = 10'000;

}  // namespace sft::test
