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

/// A set of leaf fields of a message type whose number of leaves is known at run time. Operations of two
/// masks take masks of one type.
class FieldMask {
 public:
  /// The number of a leaf.
  using value_type = std::size_t;
  /// Over the numbers of the leaves, ascending.
  using const_iterator = LeafIterator<FieldMask>;
  /// The same: sets are not changed through iterators.
  using iterator = const_iterator;

  FieldMask() = default;
  /// The empty set of a type with so many leaves.
  explicit FieldMask(std::size_t leaves) : leaves_(leaves), more_(leaves > 64 ? (leaves - 1) / 64 : 0) {}

  /// A Mask<T>, or the name of a field.
  template <FieldSet F>
  explicit FieldMask(const F& fields) : FieldMask(leaf_count_of<TypeOfFields<F>>) {
    const Mask mask(fields);
    for (std::size_t i = 0; i < mask.words.size(); ++i) mutable_word(i) = mask.words[i];
  }

  /// The set of all leaves of a type with so many.
  static FieldMask full(std::size_t leaves);
  /// Bits beyond `leaves` are ignored, missing words count as zero.
  static FieldMask from_words(std::size_t leaves, std::span<const std::uint64_t> words);

  /// Bit i of word w is leaf 64 w + i.
  std::vector<std::uint64_t> to_words() const;

  /// Leaves of the type, in the set or not.
  std::size_t leaves() const { return leaves_; }
  /// How many words of 64 leaves there are; at least one.
  std::size_t words() const { return 1 + more_.size(); }
  /// The same as words().
  std::size_t word_count() const { return words(); }
  /// One of the words, from 0.
  std::uint64_t word(std::size_t i) const { return i == 0 ? first_ : more_[i - 1]; }

  /// `leaf` is less than leaves().
  bool contains(std::size_t leaf) const { return (word(leaf / 64) >> (leaf % 64) & 1) != 0; }
  /// Whether all of the other are in this one, or any.
  bool contains(const FieldMask& other) const;
  /// True if some leaf is in both.
  bool intersects(const FieldMask& other) const;
  /// The same for a Mask<T> or the name of a field: `sample.mask().contains(F::data)`.
  template <FieldSet F>
  bool contains(const F& fields) const {
    return contains(FieldMask(fields));
  }
  /// True if some leaf is in both.
  template <FieldSet F>
  bool intersects(const F& fields) const {
    return intersects(FieldMask(fields));
  }
  /// Whether any leaf of [first, first + count) is in the set, and whether all are.
  bool any_of(std::size_t first, std::size_t count) const {
    return more_.empty() ? (first_ & bits(first, count)) != 0 : any_of_words(first, count);
  }
  /// True if all leaves of [first, first + count) are in the set.
  bool all_of(std::size_t first, std::size_t count) const {
    return more_.empty() ? (~first_ & bits(first, count)) == 0 : all_of_words(first, count);
  }
  /// The lowest leaf of [first, end) in the set, or `end`.
  std::size_t next(std::size_t first, std::size_t end) const noexcept;
  /// True if no leaf is in the set.
  bool empty() const;
  /// True if all leaves are in the set.
  bool is_full() const { return all_of(0, leaves_); }
  /// Leaves in the set.
  std::size_t size() const;

  /// Adds a leaf.
  void insert(std::size_t leaf) { mutable_word(leaf / 64) |= std::uint64_t{1} << (leaf % 64); }
  /// Removes a leaf.
  void erase(std::size_t leaf) { mutable_word(leaf / 64) &= ~(std::uint64_t{1} << (leaf % 64)); }

  /// Adds the leaves of the other.
  FieldMask& operator|=(const FieldMask& other);
  /// Keeps the leaves that are in both.
  FieldMask& operator&=(const FieldMask& other);
  /// Removes the leaves of the other.
  FieldMask& operator-=(const FieldMask& other);
  /// Keeps the leaves that are in one of both only.
  FieldMask& operator^=(const FieldMask& other);
  friend FieldMask operator|(FieldMask a, const FieldMask& b) { return a |= b; }
  friend FieldMask operator&(FieldMask a, const FieldMask& b) { return a &= b; }
  friend FieldMask operator-(FieldMask a, const FieldMask& b) { return a -= b; }
  friend FieldMask operator^(FieldMask a, const FieldMask& b) { return a ^= b; }
  friend FieldMask operator~(const FieldMask& a) { return full(a.leaves_) - a; }
  friend bool operator==(const FieldMask&, const FieldMask&) = default;

  /// The numbers of the leaves, ascending.
  iterator begin() const { return iterator::first(*this); }
  /// Behind the last one.
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
