// Masks known at compile time: Mask<T> is a set of leaves of message type T, FieldNode names a subtree of
// them, and Req<T> is what a subscriber's type says it needs: a mask, or that the fields it reads are to be
// recorded.
//
//   using F = PointCloud2::Field;
//   node.subscriber<PointCloud2, F::header.stamp | F::data>(...)
//   node.subscriber<PointCloud2, F::fields.each.name>(...)    // of each element of the sequence, its name
//   node.subscriber<PointCloud2, F::fields.size>(...)         // only how many elements it has
//
// All of it is structural, so that masks are template arguments and F::a | F::b names the same type as F::b |
// F::a. Sets of fields combine by | & - ^ ~ and compare by ==, whether they are masks or names of fields;
// sft::Mask(F::header) is the mask of a name. to_string() (type_support.h) prints them.
#pragma once

#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "sft/typesupport/leaf_iterator.h"
#include "sft/typesupport/type_table.h"

namespace sft {

/// A set of leaf fields of the message type T, as a constant expression: an argument of templates.
template <class T>
struct Mask {
  /// The message type.
  using Type = T;
  /// The number of a leaf.
  using value_type = std::size_t;
  /// Over the numbers of the leaves, ascending.
  using const_iterator = LeafIterator<Mask>;
  /// The same: sets are not changed through iterators.
  using iterator = const_iterator;
  /// Leaves of the type, in the set or not.
  static constexpr std::size_t leaves = leaf_count_of<T>;

  /// Bit i of word w is leaf 64 w + i.
  std::array<std::uint64_t, (leaves + 63) / 64> words{};  // public: a template argument has no private parts

  /// `leaf` is less than `leaves`.
  constexpr bool contains(std::size_t leaf) const { return (words[leaf / 64] >> (leaf % 64) & 1) != 0; }
  /// True if all leaves of the other are in this one.
  constexpr bool contains(const Mask& other) const {
    for (std::size_t i = 0; i < words.size(); ++i) {
      if ((other.words[i] & ~words[i]) != 0) return false;
    }
    return true;
  }

  /// True if some leaf of [first, first + count) is in the set.
  constexpr bool intersects(std::size_t first, std::size_t count) const {
    for (std::size_t leaf = first; leaf < first + count; ++leaf) {
      if (contains(leaf)) return true;
    }
    return false;
  }
  /// True if some leaf is in both.
  constexpr bool intersects(const Mask& other) const {
    for (std::size_t i = 0; i < words.size(); ++i) {
      if ((other.words[i] & words[i]) != 0) return true;
    }
    return false;
  }

  /// True if no leaf is in the set.
  constexpr bool empty() const { return size() == 0; }
  /// Leaves in the set.
  constexpr std::size_t size() const {
    std::size_t n = 0;
    for (const std::uint64_t word : words) n += static_cast<std::size_t>(std::popcount(word));
    return n;
  }

  /// The numbers of the leaves, ascending.
  constexpr iterator begin() const { return iterator::first(*this); }
  /// Behind the last one.
  constexpr iterator end() const { return iterator::end(*this); }
  /// One of the words, from 0.
  constexpr std::uint64_t word(std::size_t i) const { return words[i]; }
  /// How many words there are.
  static constexpr std::size_t word_count() { return (leaves + 63) / 64; }

  /// The set of the leaves [first, first + count).
  static constexpr Mask range(std::size_t first, std::size_t count) {
    Mask m;
    for (std::size_t leaf = first; leaf < first + count; ++leaf)
      m.words[leaf / 64] |= std::uint64_t{1} << (leaf % 64);
    return m;
  }

  friend constexpr bool operator==(const Mask&, const Mask&) = default;
};

/// All leaves below one node of T's tree. It has no members of its own but a conversion, so that the names of
/// a message's fields, which are members of classes derived from it, never collide with ours.
template <class T, std::size_t First, std::size_t Count>
struct FieldNode {
  using Type = T;
  constexpr operator Mask<T>() const {
    return Mask<T>::range(First, Count);
  }  // NOLINT(google-explicit-constructor)
};

template <class T>
inline constexpr Mask<T> all = Mask<T>::range(0, leaf_count_of<T>);

namespace detail {
template <class T, std::size_t First, std::size_t Count>
T type_of_fields(const FieldNode<T, First, Count>&);
template <class T>
T type_of_fields(const Mask<T>&);
}  // namespace detail

template <class F>
concept FieldSet = requires(const F& fields) {
  detail::type_of_fields(fields);
};

template <FieldSet F>
using TypeOfFields = decltype(detail::type_of_fields(std::declval<const F&>()));

template <FieldSet F>
Mask(const F&) -> Mask<TypeOfFields<F>>;

namespace detail {
template <FieldSet A, FieldSet B, class Combine>
constexpr auto combined(const A& a, const B& b, Combine combine) {
  using T = TypeOfFields<A>;
  static_assert(std::same_as<T, TypeOfFields<B>>, "fields of two message types in one mask");
  Mask<T> result = a;
  const Mask<T> other = b;
  for (std::size_t i = 0; i < result.words.size(); ++i)
    result.words[i] = combine(result.words[i], other.words[i]);
  return result;
}
}  // namespace detail

template <FieldSet A, FieldSet B>
constexpr auto operator|(const A& a, const B& b) {
  return detail::combined(a, b, [](std::uint64_t x, std::uint64_t y) { return x | y; });
}
template <FieldSet A, FieldSet B>
constexpr auto operator&(const A& a, const B& b) {
  return detail::combined(a, b, [](std::uint64_t x, std::uint64_t y) { return x & y; });
}
/// Those of `a` that are not in `b`.
template <FieldSet A, FieldSet B>
constexpr auto operator-(const A& a, const B& b) {
  return detail::combined(a, b, [](std::uint64_t x, std::uint64_t y) { return x & ~y; });
}
/// Those in exactly one of them.
template <FieldSet A, FieldSet B>
constexpr auto operator^(const A& a, const B& b) {
  return detail::combined(a, b, [](std::uint64_t x, std::uint64_t y) { return x ^ y; });
}
template <FieldSet A>
constexpr auto operator~(const A& fields) {
  return all<TypeOfFields<A>> - fields;
}
template <FieldSet A, FieldSet B>
constexpr bool operator==(const A& a, const B& b) {
  return (a ^ b).empty();
}

/// Requirement mechanism "automatic requirement recording" (ARR): getters note what is read.
struct Recorded {
  friend constexpr bool operator==(Recorded, Recorded) = default;
};
inline constexpr Recorded recorded{};

/// What a subscriber requires: fields of T that it declares, or recording.
template <class T>
struct Req {
  /// The fields; of recording all.
  Mask<T> mask{};
  /// Getters note what is read (ARR).
  bool is_recorded = false;

  /// These fields are declared.
  constexpr Req(const Mask<T>& declared) : mask(declared) {}  // NOLINT(google-explicit-constructor)
  /// A field or an inner node by its name (a class derived from FieldNode), or a combination of them.
  template <FieldSet F>
  requires std::same_as<T, TypeOfFields<F>>
  constexpr Req(const F& declared) : mask(declared) {}  // NOLINT(google-explicit-constructor)
  /// Which fields are needed is found out.
  constexpr Req(Recorded) : mask(all<T>), is_recorded(true) {}  // NOLINT(google-explicit-constructor)

  friend constexpr bool operator==(const Req&, const Req&) = default;
};

}  // namespace sft
