// The output of encoders: a BodyWriter writes members, and a BodyCounter only counts their bytes. Neither
// of them stores a position. Each call takes the position where it begins and returns the position where it
// ends, so that compilers keep the position in a register.
#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "sft/detail/postponed_copies.h"
#include "sft/detail/walk.h"

namespace sft::detail {

class BodyCounter {
 public:
  std::uint64_t align(std::uint64_t at, std::size_t alignment) const { return align_up(at, alignment); }
  std::uint64_t put(std::uint64_t at, const void*, std::size_t bytes) const { return at + bytes; }
  std::uint64_t put_run(std::uint64_t at, const std::byte*, std::size_t bytes) const { return at + bytes; }
  std::uint64_t put_swapped(std::uint64_t at, const void*, std::size_t count, std::size_t size) const {
    return at + count * size;
  }
};

/// A writer into `body`, which must be large enough. Padding is zero. If `postponed` is not null, long runs
/// are added to it and not written.
class BodyWriter {
 public:
  explicit BodyWriter(std::span<std::byte> body, PostponedCopies* postponed = nullptr)
      : body_(body), postponed_(postponed) {}

  std::uint64_t align(std::uint64_t at, std::size_t alignment) const {
    const std::uint64_t aligned = align_up(at, alignment);
    assert(aligned <= body_.size());
    // At most 7 bytes; for a loop, the compiler would insert a call.
    const std::uint64_t padding = aligned - at;
    std::byte* to = body_.data() + at;
    if ((padding & 1) != 0) *to++ = std::byte{0};
    if ((padding & 2) != 0) std::memset(to, 0, 2), to += 2;
    if ((padding & 4) != 0) std::memset(to, 0, 4);
    return aligned;
  }

  std::uint64_t put(std::uint64_t at, const void* data, std::size_t bytes) const {
    assert(at + bytes <= body_.size());
    std::byte* to = body_.data() + at;
    switch (bytes) {  // a copy of a single primitive takes one instruction
      case 0:
        break;
      case 1:
        std::memcpy(to, data, 1);
        break;
      case 2:
        std::memcpy(to, data, 2);
        break;
      case 4:
        std::memcpy(to, data, 4);
        break;
      case 8:
        std::memcpy(to, data, 8);
        break;
      default:
        std::memcpy(to, data, bytes);
    }
    return at + bytes;
  }

  /// Writes primitives that may be copied later, because no code reads them while the body is written or
  /// projected.
  std::uint64_t put_run(std::uint64_t at, const std::byte* data, std::size_t bytes) const {
    if (postponed_ == nullptr || !postponed_->add(body_.data() + at, data, bytes))
      return put(at, data, bytes);
    return at + bytes;
  }

  /// Writes `count` primitives of `size` bytes, each with its bytes in reverse order.
  std::uint64_t put_swapped(std::uint64_t at, const void* data, std::size_t count, std::size_t size) const {
    assert(at + count * size <= body_.size());
    const auto* from = static_cast<const std::byte*>(data);
    std::byte* to = body_.data() + at;
    switch (size) {
      case 2:
        swap_each<std::uint16_t>(from, count, to);
        break;
      case 4:
        swap_each<std::uint32_t>(from, count, to);
        break;
      case 8:
        swap_each<std::uint64_t>(from, count, to);
        break;
      default:
        std::memcpy(to, from, count);
    }
    return at + count * size;
  }

 private:
  static std::uint16_t swapped(std::uint16_t v) { return __builtin_bswap16(v); }
  static std::uint32_t swapped(std::uint32_t v) { return __builtin_bswap32(v); }
  static std::uint64_t swapped(std::uint64_t v) { return __builtin_bswap64(v); }

  template <class Word>
  static void swap_each(const std::byte* from, std::size_t count, std::byte* to) {
    for (std::size_t i = 0; i < count; ++i) {
      Word word;
      std::memcpy(&word, from + i * sizeof word, sizeof word);
      word = swapped(word);
      std::memcpy(to + i * sizeof word, &word, sizeof word);
    }
  }

  std::span<std::byte> body_;
  PostponedCopies* postponed_;
};

}  // namespace sft::detail
