// Sets of fields. A field set is a set of leaves (type.h) of one message type. There are two forms of it:
//
//   Mask<T>      known at compile time, from the generated names of the fields of message type T
//   FieldMask    known at run time, as wide as the type needs; holds no heap memory up to 64 leaves
//
//   using F = PointCloud2::Field;
//   node.subscriber<PointCloud2, F::header.stamp | F::data>(...)
//   node.subscriber<PointCloud2, F::fields.each.name>(...)    // the name of each element of the sequence
//   node.subscriber<PointCloud2, F::fields.size>(...)         // only the number of elements
//   node.subscriber<PointCloud2, F::data.channels<"x", "y">>(...)  // a part of a field
//
// Sets of one type combine by | & - ^ ~ and compare by ==, whether they are masks or names of fields;
// sft::Mask(F::header) is the mask of a name. F::a | F::b names the same type as F::b | F::a, so that both
// are the same template argument. A set does not know the names of its type: to_string() and TypeSupport
// (type_support.h) print it and read it from text.
//
// Sets are values: several threads may read a set. While a thread changes a set, no other thread may use
// that set. No function here fails; a FieldMask of more than 64 leaves allocates when it is made or copied.
#pragma once

#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "sft/detail/declared_part.h"
#include "sft/detail/leaf_iterator.h"
#include "sft/detail/type_table.h"

namespace sft {

/// A set of leaves of message type T that is known at compile time. It is meant for template arguments.
template <class T>
struct Mask {
  /// The message type of the mask.
  using Type = T;
  /// The type of a leaf's number.
  using value_type = std::size_t;
  /// Iterates over the numbers of the leaves in ascending order.
  using const_iterator = detail::LeafIterator<Mask>;
  /// The same type as const_iterator, since iterators do not change sets.
  using iterator = const_iterator;
  /// The number of leaves of the type, not only of those in the set.
  static constexpr std::size_t leaves = detail::leaf_count_of<T>;

  /// Bit b of word i stands for leaf 64 * i + b.
  std::array<std::uint64_t, (leaves + 63) / 64> words{};  // public, because masks are template arguments

  /// Returns true if the leaf is in the mask.
  constexpr bool contains(std::size_t leaf) const { return (words[leaf / 64] >> (leaf % 64) & 1) != 0; }
  /// Returns true if all leaves of the other mask are in this mask.
  constexpr bool contains(const Mask& other) const {
    for (std::size_t i = 0; i < words.size(); ++i) {
      if ((other.words[i] & ~words[i]) != 0) return false;
    }
    return true;
  }

  /// Returns true if any leaf of [first, first + count) is in the mask.
  constexpr bool intersects(std::size_t first, std::size_t count) const {
    for (std::size_t leaf = first; leaf < first + count; ++leaf) {
      if (contains(leaf)) return true;
    }
    return false;
  }
  /// Returns true if any leaf of the other mask is in this mask.
  constexpr bool intersects(const Mask& other) const {
    for (std::size_t i = 0; i < words.size(); ++i) {
      if ((other.words[i] & words[i]) != 0) return true;
    }
    return false;
  }

  /// Returns true if no leaf is in the set.
  constexpr bool empty() const { return size() == 0; }
  /// Returns the number of leaves in the set.
  constexpr std::size_t size() const {
    std::size_t n = 0;
    for (const std::uint64_t word : words) n += static_cast<std::size_t>(std::popcount(word));
    return n;
  }

  /// Returns an iterator to the first leaf of the set. Leaves come in ascending order.
  constexpr iterator begin() const { return iterator::first(*this); }
  /// Returns the iterator past the last leaf.
  constexpr iterator end() const { return iterator::end(*this); }
  /// Returns word i, counted from 0.
  constexpr std::uint64_t word(std::size_t i) const { return words[i]; }
  /// Returns the number of words.
  static constexpr std::size_t word_count() { return (leaves + 63) / 64; }

  /// Returns the set of the leaves [first, first + count).
  static constexpr Mask range(std::size_t first, std::size_t count) {
    Mask m;
    for (std::size_t leaf = first; leaf < first + count; ++leaf)
      m.words[leaf / 64] |= std::uint64_t{1} << (leaf % 64);
    return m;
  }

  friend constexpr bool operator==(const Mask&, const Mask&) = default;
};

/// All fields of message type T.
template <class T>
inline constexpr Mask<T> all = Mask<T>::range(0, detail::leaf_count_of<T>);

namespace detail {

/// All leaves below one node of T's tree. The struct has no member function except a conversion. So the
/// names of a message's fields, which are members of derived classes, never collide with a function.
template <class T, std::size_t First, std::size_t Count>
struct FieldNode {
  using Type = T;
  constexpr operator Mask<T>() const {
    return Mask<T>::range(First, Count);
  }  // NOLINT(google-explicit-constructor)
};

template <class T, std::size_t First, std::size_t Count>
T type_of_fields(const FieldNode<T, First, Count>&);
template <class T>
T type_of_fields(const Mask<T>&);

/// A type that is a mask or the name of a field.
template <class F>
concept FieldSet = requires(const F& fields) {
  detail::type_of_fields(fields);
};

template <FieldSet F>
using TypeOfFields = decltype(detail::type_of_fields(std::declval<const F&>()));

}  // namespace detail

template <detail::FieldSet F>
Mask(const F&) -> Mask<detail::TypeOfFields<F>>;

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

template <FieldSet A, FieldSet B>
constexpr auto operator|(const A& a, const B& b) {
  return combined(a, b, [](std::uint64_t x, std::uint64_t y) { return x | y; });
}
template <FieldSet A, FieldSet B>
constexpr auto operator&(const A& a, const B& b) {
  return combined(a, b, [](std::uint64_t x, std::uint64_t y) { return x & y; });
}
/// Returns the leaves of `a` that are not in `b`.
template <FieldSet A, FieldSet B>
constexpr auto operator-(const A& a, const B& b) {
  return combined(a, b, [](std::uint64_t x, std::uint64_t y) { return x & ~y; });
}
/// Returns the leaves in exactly one of the two sets.
template <FieldSet A, FieldSet B>
constexpr auto operator^(const A& a, const B& b) {
  return combined(a, b, [](std::uint64_t x, std::uint64_t y) { return x ^ y; });
}
template <FieldSet A>
constexpr auto operator~(const A& fields) {
  return all<TypeOfFields<A>> - fields;
}
template <FieldSet A, FieldSet B>
constexpr bool operator==(const A& a, const B& b) {
  return (a ^ b).empty();
}

}  // namespace detail

// Argument-dependent lookup finds the operators for masks in this namespace, and those for names of fields
// in sft::detail.
using detail::operator|;
using detail::operator&;
using detail::operator-;
using detail::operator^;
using detail::operator~;
using detail::operator==;

namespace detail {

/// Whole fields of message type T, and fields of which a part is declared.
template <class T>
struct Declared {
  Mask<T> whole{};        ///< the fields of which no part is declared
  DeclaredParts parts{};  ///< the parts, followed by unused entries

  constexpr Mask<T> mask() const {
    Mask<T> all = whole;
    for (const DeclaredPart& part : parts) {
      if (!part.is_whole()) all = all | Mask<T>::range(part.leaf, 1);
    }
    return all;
  }
  constexpr void add(const DeclaredPart& part) {
    if (part.is_whole() || whole.contains(part.leaf)) return;
    for (DeclaredPart& place : parts) {
      if (place.is_whole()) {
        place = part;
        return;
      }
      if (place.leaf == part.leaf && place != part) a_field_has_two_parts();
      if (place.leaf == part.leaf) return;
    }
    there_are_too_many_parts();
  }
};

/// A part of a field of message type T. The field is a sequence of values. The functions restrict the part.
template <class T>
struct FieldPart {
  Mask<T> beside{};  ///< fields that are needed to interpret the part
  DeclaredPart part{};

  /// Keeps each n-th element, or each n-th point or pixel of a row. If range() or columns() was called
  /// before, counts within that range. n >= 1.
  constexpr FieldPart every(std::uint32_t n) const {
    FieldPart other = *this;
    if (other.part.columns.step != 0) a_range_is_given_twice();
    other.part.columns.step = declared_range(0, 0, n).step;
    return other;
  }
  /// Keeps the elements [begin, end), or these points or pixels of each row. An `end` of 0 means that the
  /// range has no end.
  constexpr FieldPart range(std::uint32_t begin, std::uint32_t end, std::uint32_t step = 1) const {
    return columns(begin, end, step);
  }
  /// Keeps the rows [begin, end).
  constexpr FieldPart rows(std::uint32_t begin, std::uint32_t end, std::uint32_t step = 1) const {
    FieldPart other = *this;
    if (other.part.rows != DeclaredRange{}) a_range_is_given_twice();
    other.part.rows = declared_range(begin, end, step);
    return other;
  }
  /// Keeps the columns [begin, end).
  constexpr FieldPart columns(std::uint32_t begin, std::uint32_t end, std::uint32_t step = 1) const {
    FieldPart other = *this;
    if (other.part.columns != DeclaredRange{}) a_range_is_given_twice();
    other.part.columns = declared_range(begin, end, step);
    return other;
  }
};

template <class T>
constexpr Declared<T> to_declared(const Declared<T>& declared) {
  return declared;
}
template <class T>
constexpr Declared<T> to_declared(const FieldPart<T>& part) {
  Declared<T> declared{.whole = part.beside};
  if (part.part.is_whole()) declared.whole = declared.whole | Mask<T>::range(part.part.leaf, 1);
  declared.add(part.part);
  return declared;
}
template <FieldSet F>
constexpr Declared<TypeOfFields<F>> to_declared(const F& fields) {
  return {.whole = fields};
}

template <class T>
T type_of_parts(const Declared<T>&);
template <class T>
T type_of_parts(const FieldPart<T>&);
/// A type that declares a part of a field.
template <class P>
concept PartSet = requires(const P& parts) {
  detail::type_of_parts(parts);
};

template <class A, class B>
requires((PartSet<A> && (PartSet<B> || FieldSet<B>)) || (FieldSet<A> && PartSet<B>)) constexpr auto operator|(
    const A& a, const B& b) {
  auto joined = to_declared(a);
  const decltype(joined) other = to_declared(b);  // both operands have fields of the same message type
  const DeclaredParts parts = joined.parts;
  joined.whole = joined.whole | other.whole;
  joined.parts = {};
  for (const DeclaredPart& part : parts) joined.add(part);
  for (const DeclaredPart& part : other.parts) joined.add(part);
  return joined;
}

}  // namespace detail

namespace detail {
/// The type of the constant sft::recorded.
struct Recorded {
  friend constexpr bool operator==(Recorded, Recorded) = default;
};
/// The type of the constant sft::selected.
struct Selected {
  friend constexpr bool operator==(Selected, Selected) = default;
};
}  // namespace detail

/// Stands in place of a mask. The getters of the subscriber's samples note which fields the program reads,
/// and the subscriber requests these fields.
inline constexpr detail::Recorded recorded{};
/// Stands in place of a mask. Texts that the program passes at run time name the fields
/// (SubscriberOptions::selection).
inline constexpr detail::Selected selected{};

/// The requirement of a subscriber, as a template argument: a mask, the name of a field, sft::recorded, or
/// sft::selected.
template <class T>
struct Req {
  /// The declared fields; all fields if they are recorded or selected.
  Mask<T> mask{};
  /// True if getters note which fields are read (ARR).
  bool is_recorded = false;
  /// True if texts name the fields at run time.
  bool is_selected = false;
  /// The fields of which only a part is declared.
  detail::DeclaredParts parts{};

  /// Requires the fields of the mask.
  constexpr Req(const Mask<T>& declared) : mask(declared) {}  // NOLINT(google-explicit-constructor)
  /// Requires a field or an inner node by its name, or a combination of such nodes.
  template <detail::FieldSet F>
  requires std::same_as<T, detail::TypeOfFields<F>>
  constexpr Req(const F& declared) : mask(declared) {}  // NOLINT(google-explicit-constructor)
  /// Requires parts of fields, and other fields: `F::width | F::data.channels<"x">`.
  template <detail::PartSet P>
  requires std::same_as<T, decltype(detail::type_of_parts(std::declval<const P&>()))>
  constexpr Req(const P& declared)  // NOLINT(google-explicit-constructor)
      : mask(detail::to_declared(declared).mask()), parts(detail::to_declared(declared).parts) {}
  /// Requires the fields that are recorded at run time.
  constexpr Req(detail::Recorded) : mask(all<T>), is_recorded(true) {}  // NOLINT(google-explicit-constructor)

  /// Requires the fields that texts name at run time.
  constexpr Req(detail::Selected) : mask(all<T>), is_selected(true) {}  // NOLINT(google-explicit-constructor)

  /// Returns true if a sample may lack fields that have getters. Those getters return sft::Optional.
  constexpr bool may_lack() const { return is_recorded || is_selected; }
  friend constexpr bool operator==(const Req&, const Req&) = default;
};

/// A set of leaves at run time. A default-constructed set belongs to a type without leaves. All numbers of
/// leaves that are passed to it must be less than leaves().
/// Larger than usual: it is a set with all of its operators.
class FieldMask {
 public:
  /// The type of a leaf's number.
  using value_type = std::size_t;
  /// Iterates over the numbers of the leaves in ascending order.
  using const_iterator = detail::LeafIterator<FieldMask>;
  /// The same type as const_iterator, since iterators do not change sets.
  using iterator = const_iterator;

  FieldMask() = default;
  /// Makes the empty set of a type with this number of leaves.
  explicit FieldMask(std::size_t leaves) : leaves_(leaves), more_(leaves > 64 ? (leaves - 1) / 64 : 0) {}

  /// Converts a Mask<T> or the name of a field to a FieldMask.
  template <detail::FieldSet F>
  explicit FieldMask(const F& fields) : FieldMask(detail::leaf_count_of<detail::TypeOfFields<F>>) {
    const Mask mask(fields);
    for (std::size_t i = 0; i < mask.words.size(); ++i) mutable_word(i) = mask.words[i];
  }

  /// Returns the set of all leaves of a type with this number of leaves.
  static FieldMask full(std::size_t leaves);
  /// Makes a set from words. Bit b of word i stands for leaf 64 * i + b. Bits beyond `leaves` are ignored,
  /// and missing words count as zero.
  static FieldMask from_words(std::size_t leaves, std::span<const std::uint64_t> words);

  /// Returns the words of the set. Bit b of word i stands for leaf 64 * i + b.
  std::vector<std::uint64_t> to_words() const;

  /// Returns the number of leaves of the type, not only of those in the set.
  std::size_t leaves() const { return leaves_; }
  /// Returns the number of words of 64 leaves each; at least one.
  std::size_t words() const { return 1 + more_.size(); }
  /// Returns the same as words().
  std::size_t word_count() const { return words(); }
  /// Returns word i, counted from 0.
  std::uint64_t word(std::size_t i) const { return i == 0 ? first_ : more_[i - 1]; }

  /// Returns true if the leaf is in the set. REQUIRES: leaf < leaves().
  bool contains(std::size_t leaf) const { return (word(leaf / 64) >> (leaf % 64) & 1) != 0; }
  /// Returns true if all leaves of the other set, which must be of the same type, are in this set.
  bool contains(const FieldMask& other) const;
  /// Returns true if any leaf of the other set, which must be of the same type, is in this set.
  bool intersects(const FieldMask& other) const;
  /// Returns true if all leaves of a Mask<T>, or of a field that is given by its name, are in this set:
  /// `sample.mask().contains(F::data)`.
  template <detail::FieldSet F>
  bool contains(const F& fields) const {
    return contains(FieldMask(fields));
  }
  /// Returns true if any of these fields is in the set.
  template <detail::FieldSet F>
  bool intersects(const F& fields) const {
    return intersects(FieldMask(fields));
  }
  /// Returns true if any leaf of [first, first + count) is in the set.
  bool any_of(std::size_t first, std::size_t count) const {
    return more_.empty() ? (first_ & bits(first, count)) != 0 : any_of_words(first, count);
  }
  /// Returns true if all leaves of [first, first + count) are in the set.
  bool all_of(std::size_t first, std::size_t count) const {
    return more_.empty() ? (~first_ & bits(first, count)) == 0 : all_of_words(first, count);
  }
  /// Returns the lowest leaf of [first, end) that is in the set, or `end` if the set has no such leaf.
  std::size_t next(std::size_t first, std::size_t end) const noexcept;
  /// Returns true if no leaf is in the set.
  bool empty() const;
  /// Returns true if all leaves are in the set.
  bool is_full() const { return all_of(0, leaves_); }
  /// Returns the number of leaves in the set.
  std::size_t size() const;

  /// Adds a leaf.
  void insert(std::size_t leaf) { mutable_word(leaf / 64) |= std::uint64_t{1} << (leaf % 64); }
  /// Removes a leaf.
  void erase(std::size_t leaf) { mutable_word(leaf / 64) &= ~(std::uint64_t{1} << (leaf % 64)); }

  /// Adds the leaves of the other set.
  FieldMask& operator|=(const FieldMask& other);
  /// Keeps the leaves that are in both sets.
  FieldMask& operator&=(const FieldMask& other);
  /// Removes the leaves of the other set.
  FieldMask& operator-=(const FieldMask& other);
  /// Keeps the leaves that are in exactly one of the two sets.
  FieldMask& operator^=(const FieldMask& other);
  friend FieldMask operator|(FieldMask a, const FieldMask& b) { return a |= b; }
  friend FieldMask operator&(FieldMask a, const FieldMask& b) { return a &= b; }
  friend FieldMask operator-(FieldMask a, const FieldMask& b) { return a -= b; }
  friend FieldMask operator^(FieldMask a, const FieldMask& b) { return a ^= b; }
  friend FieldMask operator~(const FieldMask& a) { return full(a.leaves_) - a; }
  friend bool operator==(const FieldMask&, const FieldMask&) = default;

  /// Returns an iterator to the first leaf of the set. Leaves come in ascending order. The set must not
  /// change during an iteration.
  iterator begin() const { return iterator::first(*this); }
  /// Returns the iterator past the last leaf.
  iterator end() const { return iterator::end(*this); }

  /// Returns a hash. Equal sets have equal hashes. If the type has at most 64 leaves, the hash consists of
  /// the bits of the set.
  std::uint64_t hash() const;

 private:
  /// Returns the bits of these leaves in the first word. REQUIRES: the first word has all of them.
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
