// A set of leaves at run time, as wide as the type needs. Up to 64 leaves it holds no heap memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sft/typesupport/mask.h"

namespace sft {

class FieldMask {
 public:
  FieldMask() = default;
  explicit FieldMask(std::size_t leaves) : leaves_(leaves), more_(leaves > 64 ? (leaves - 1) / 64 : 0) {}

  template <class T>
  explicit FieldMask(const Mask<T>& mask) : FieldMask(mask.leaves) {
    for (std::size_t i = 0; i < mask.words.size(); ++i) mutable_word(i) = mask.words[i];
  }

  template <class T, std::size_t First, std::size_t Count>
  explicit FieldMask(const FieldNode<T, First, Count>& fields) : FieldMask(Mask<T>(fields)) {}

  static FieldMask full(std::size_t leaves);
  /// Bits beyond `leaves` are ignored, missing words count as zero.
  static FieldMask from_words(std::size_t leaves, std::span<const std::uint64_t> words);

  std::vector<std::uint64_t> to_words() const;

  std::size_t leaves() const { return leaves_; }
  std::size_t words() const { return 1 + more_.size(); }
  std::uint64_t word(std::size_t i) const { return i == 0 ? first_ : more_[i - 1]; }

  bool contains(std::size_t leaf) const { return (word(leaf / 64) >> (leaf % 64) & 1) != 0; }
  bool contains(const FieldMask& other) const;
  /// Whether any leaf of [first, first + count) is in the set, and whether all are.
  bool any_of(std::size_t first, std::size_t count) const {
    return more_.empty() ? (first_ & bits(first, count)) != 0 : any_of_words(first, count);
  }
  bool all_of(std::size_t first, std::size_t count) const {
    return more_.empty() ? (~first_ & bits(first, count)) == 0 : all_of_words(first, count);
  }
  bool empty() const;
  bool is_full() const { return all_of(0, leaves_); }
  std::size_t size() const;

  void insert(std::size_t leaf) { mutable_word(leaf / 64) |= std::uint64_t{1} << (leaf % 64); }
  void erase(std::size_t leaf) { mutable_word(leaf / 64) &= ~(std::uint64_t{1} << (leaf % 64)); }
  FieldMask& operator|=(const FieldMask& other);

  friend bool operator==(const FieldMask&, const FieldMask&) = default;

  /// Equal masks have equal hashes; at most 64 leaves: the bits themselves.
  std::uint64_t hash() const;

 private:
  /// Within the first word, which has them all.
  static constexpr std::uint64_t bits(std::size_t first, std::size_t count) {
    return count == 0 ? 0 : ~std::uint64_t{0} >> (64 - count) << first;
  }
  bool any_of_words(std::size_t first, std::size_t count) const;
  bool all_of_words(std::size_t first, std::size_t count) const;
  std::uint64_t& mutable_word(std::size_t i) { return i == 0 ? first_ : more_[i - 1]; }

  std::size_t leaves_ = 0;
  std::uint64_t first_ = 0;
  std::vector<std::uint64_t> more_;
};

}  // namespace sft
