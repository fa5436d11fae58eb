// Where encoded members go: a BodyWriter writes them, a BodyCounter only counts what that would take.
#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "sft/typesupport/walk.h"

namespace sft {

class BodyCounter {
 public:
  void align(std::size_t alignment) { at_ = align_up(at_, alignment); }
  void put(const void*, std::size_t bytes) { at_ += bytes; }
  void put_swapped(const void*, std::size_t count, std::size_t element_bytes) {
    at_ += count * element_bytes;
  }
  void leave(std::size_t bytes) { at_ += bytes; }
  std::uint64_t at() const { return at_; }

 private:
  std::uint64_t at_ = 0;
};

/// What is put must fit. Padding is zero.
class BodyWriter {
 public:
  explicit BodyWriter(std::span<std::byte> body) : body_(body) {}

  void align(std::size_t alignment) {
    const std::uint64_t aligned = align_up(at_, alignment);
    assert(aligned <= body_.size());
    while (at_ < aligned) body_[at_++] = std::byte{0};
  }
  void put(const void* data, std::size_t bytes) {
    assert(at_ + bytes <= body_.size());
    if (bytes != 0) std::memcpy(body_.data() + at_, data, bytes);
    at_ += bytes;
  }
  /// `count` primitives, the bytes of each in reverse order.
  void put_swapped(const void* data, std::size_t count, std::size_t element_bytes) {
    assert(at_ + count * element_bytes <= body_.size());
    const auto* from = static_cast<const std::byte*>(data);
    std::byte* to = body_.data() + at_;
    if (element_bytes == 2) {
      swap_each<std::uint16_t>(from, count, to);
    } else if (element_bytes == 4) {
      swap_each<std::uint32_t>(from, count, to);
    } else if (element_bytes == 8) {
      swap_each<std::uint64_t>(from, count, to);
    } else if (count != 0) {
      std::memcpy(to, from, count);
    }
    at_ += count * element_bytes;
  }
  void leave(std::size_t bytes) { at_ += bytes; }
  std::uint64_t at() const { return at_; }

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
  std::uint64_t at_ = 0;
};

}  // namespace sft
