// A set of leaves at run time, as wide as the type needs. Up to 64 leaves it holds no heap memory.
//
// Sets combine and compare with those of the same type: `a | b`, `a & b`, `a - b`, `a ^ b`, `~a`, `a == b`.
// A set does not know its type: TypeSupport (type_support.h) reads it from text and prints it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sft/typesupport/leaf_iterator.h"
#include "sft/typesupport/mask.h"

namespace sft {

class FieldMask {
 public:
  using value_type = std::size_t;
  using const_iterator = LeafIterator<FieldMask>;
  using iterator = const_iterator;

  FieldMask() = default;
  explicit FieldMask(std::size_t leaves) : leaves_(leaves), more_(leaves > 64 ? (leaves - 1) / 64 : 0) {}

  /// A Mask<T>, or the name of a field.
  template <FieldSet F>
  explicit FieldMask(const F& fields) : FieldMask(leaf_count_of<TypeOfFields<F>>) {
    const Mask mask(fields);
    for (std::size_t i = 0; i < mask.words.size(); ++i) mutable_word(i) = mask.words[i];
  }

  static FieldMask full(std::size_t leaves);
  /// Bits beyond `leaves` are ignored, missing words count as zero.
  static FieldMask from_words(std::size_t leaves, std::span<const std::uint64_t> words);

  std::vector<std::uint64_t> to_words() const;

  std::size_t leaves() const { return leaves_; }
  std::size_t words() const { return 1 + more_.size(); }
  std::size_t word_count() const { return words(); }
  std::uint64_t word(std::size_t i) const { return i == 0 ? first_ : more_[i - 1]; }

  bool contains(std::size_t leaf) const { return (word(leaf / 64) >> (leaf % 64) & 1) != 0; }
  /// Whether all of the other are in this one, or any.
  bool contains(const FieldMask& other) const;
  bool intersects(const FieldMask& other) const;
  /// The same for a Mask<T> or the name of a field: `sample.mask().contains(F::data)`.
  template <FieldSet F>
  bool contains(const F& fields) const {
    return contains(FieldMask(fields));
  }
  template <FieldSet F>
  bool intersects(const F& fields) const {
    return intersects(FieldMask(fields));
  }
  /// Whether any leaf of [first, first + count) is in the set, and whether all are.
  bool any_of(std::size_t first, std::size_t count) const {
    return more_.empty() ? (first_ & bits(first, count)) != 0 : any_of_words(first, count);
  }
  bool all_of(std::size_t first, std::size_t count) const {
    return more_.empty() ? (~first_ & bits(first, count)) == 0 : all_of_words(first, count);
  }
  /// The lowest leaf of [first, end) in the set, or `end`.
  std::size_t next(std::size_t first, std::size_t end) const noexcept;
  bool empty() const;
  bool is_full() const { return all_of(0, leaves_); }
  std::size_t size() const;

  void insert(std::size_t leaf) { mutable_word(leaf / 64) |= std::uint64_t{1} << (leaf % 64); }
  void erase(std::size_t leaf) { mutable_word(leaf / 64) &= ~(std::uint64_t{1} << (leaf % 64)); }

  FieldMask& operator|=(const FieldMask& other);
  FieldMask& operator&=(const FieldMask& other);
  FieldMask& operator-=(const FieldMask& other);
  FieldMask& operator^=(const FieldMask& other);
  friend FieldMask operator|(FieldMask a, const FieldMask& b) { return a |= b; }
  friend FieldMask operator&(FieldMask a, const FieldMask& b) { return a &= b; }
  friend FieldMask operator-(FieldMask a, const FieldMask& b) { return a -= b; }
  friend FieldMask operator^(FieldMask a, const FieldMask& b) { return a ^= b; }
  friend FieldMask operator~(const FieldMask& a) { return full(a.leaves_) - a; }
  friend bool operator==(const FieldMask&, const FieldMask&) = default;

  /// The numbers of the leaves, ascending.
  iterator begin() const { return iterator::first(*this); }
  iterator end() const { return iterator::end(*this); }

  /// Equal masks have equal hashes; at most 64 leaves: the bits themselves.
  std::uint64_t hash() const;

 private:
  /// Within the first word, which has them all.
  static constexpr std::uint64_t bits(std::size_t first, std::size_t count) {
    return count == 0 ? 0 : ~std::uint64_t{0} >> (64 - count) << first;
  }
  bool any_of_words(std::size_t first, std::size_t count) const;
  bool all_of_words(std::size_t first, std::size_t count) const;
  template <class Combine>
  FieldMask& combine(const FieldMask& other, Combine combine);
  std::uint64_t& mutable_word(std::size_t i) { return i == 0 ? first_ : more_[i - 1]; }

  std::size_t leaves_ = 0;
  std::uint64_t first_ = 0;
  std::vector<std::uint64_t> more_;
};

}  // namespace sft
