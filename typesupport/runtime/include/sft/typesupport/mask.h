// Masks known at compile time: Mask<T> is a set of leaves of message type T, FieldNode names a subtree of
// them, and Req<T> is what a subscriber's type says it needs: a mask, or that the fields it reads are to be
// recorded.
//
//   using F = PointCloud2::Field;
//   node.subscriber<PointCloud2, F::header.stamp | F::data>(...)
//
// All of it is structural, so that masks are template arguments and F::a | F::b names the same type as F::b |
// F::a.
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "sft/typesupport/type_table.h"

namespace sft {

template <class T>
struct Mask {
  using Type = T;
  static constexpr std::size_t leaves = leaf_count_of<T>;

  std::array<std::uint64_t, (leaves + 63) / 64> words{};  // public: a template argument has no private parts

  constexpr bool contains(std::size_t leaf) const { return (words[leaf / 64] >> (leaf % 64) & 1) != 0; }

  constexpr bool intersects(std::size_t first, std::size_t count) const {
    for (std::size_t leaf = first; leaf < first + count; ++leaf) {
      if (contains(leaf)) return true;
    }
    return false;
  }

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

template <FieldSet A, FieldSet B>
constexpr auto operator|(const A& a, const B& b) {
  using T = decltype(detail::type_of_fields(a));
  static_assert(std::same_as<T, decltype(detail::type_of_fields(b))>,
                "fields of two message types in one mask");
  Mask<T> result = a;
  const Mask<T> other = b;
  for (std::size_t i = 0; i < result.words.size(); ++i) result.words[i] |= other.words[i];
  return result;
}

template <FieldSet A>
constexpr auto operator~(const A& fields) {
  using T = decltype(detail::type_of_fields(fields));
  Mask<T> result = all<T>;
  const Mask<T> without = fields;
  for (std::size_t i = 0; i < result.words.size(); ++i) result.words[i] &= ~without.words[i];
  return result;
}

/// Requirement mechanism "automatic requirement recording" (ARR): getters note what is read.
struct Recorded {
  friend constexpr bool operator==(Recorded, Recorded) = default;
};
inline constexpr Recorded recorded{};

template <class T>
struct Req {
  Mask<T> mask{};
  bool is_recorded = false;

  constexpr Req(const Mask<T>& declared) : mask(declared) {}  // NOLINT(google-explicit-constructor)
  /// A field or an inner node by its name (a class derived from FieldNode), or a combination of them.
  template <FieldSet F>
  requires std::same_as<T, decltype(detail::type_of_fields(std::declval<const F&>()))>
  constexpr Req(const F& declared) : mask(declared) {}          // NOLINT(google-explicit-constructor)
  constexpr Req(Recorded) : mask(all<T>), is_recorded(true) {}  // NOLINT(google-explicit-constructor)

  friend constexpr bool operator==(const Req&, const Req&) = default;
};

}  // namespace sft
