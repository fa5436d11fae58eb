// Lazy views. A generated View<Place> has one getter per member. The Place says where the members are: at
// slots of the index (IndexedPlace), or one after the other in an element of a sequence (ElementPlace). A
// view owns nothing and must not outlive the sample to which it refers.
//
//   scalar               -> its value             string               -> std::string_view
//   array, sequence      -> std::span             ... of strings       -> StringRange
//   struct               -> a View                ... of structs       -> ElementRange of Views
//
// Ranges have random access (element_range.h).
//
// Under a declared mask a getter of an absent field does not exist. If fields are recorded, getters of leaves
// note the access, and return std::optional, which is empty if this sample does not have the field.
#pragma once

#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <tuple>
#include <type_traits>

#include "sft/detail/element_range.h"
#include "sft/detail/walk.h"
#include "sft/mask.h"
#include "sft/optional.h"

namespace sft::detail {

static_assert(std::endian::native == std::endian::little, "views read little-endian CDR in place");

/// True if the mask that the reader declared has the field or a leaf below it. Generated getters require
/// this concept.
template <class Place, std::size_t Member>
concept field_is_in_declared_mask = Place::template has<Member>;

/// The return type of the deleted getters of fields that were not declared. Error messages of compilers
/// show this name.
struct this_field_is_not_declared {
  struct name_it_where_the_subscriber_is_opened {};
};

template <auto R, class V>
using Got = std::conditional_t<R.may_lack(), Optional<V>, V>;

/// The types of the primitives, in the order of their kinds.
using Scalars = std::tuple<bool, std::uint8_t, char, std::int8_t, std::uint8_t, std::int16_t, std::uint16_t,
                           std::int32_t, std::uint32_t, std::int64_t, std::uint64_t, float, double>;
static_assert(is_primitive(static_cast<Kind>(std::tuple_size_v<Scalars> - 1)) &&
              !is_primitive(static_cast<Kind>(std::tuple_size_v<Scalars>)));

template <Kind K>
using ScalarOf = std::tuple_element_t<static_cast<std::size_t>(K), Scalars>;

/// A boolean in an array or a sequence is read as its byte, since a span of bool over foreign bytes would be
/// undefined.
template <Kind K>
using ElementOf = std::conditional_t<K == Kind::boolean, std::uint8_t, ScalarOf<K>>;

template <class V>
V load(const SampleState& s, std::uint64_t offset) noexcept {
  const std::uint32_t at = checked_block(s, offset, 1, sizeof(V));
  V value{};
  if (at == no_offset) {
    s.flag_malformed();
  } else if constexpr (std::same_as<V, bool>) {
    value = s.body[at] != std::byte{0};
  } else if constexpr (std::integral<V>) {
    value = read_once<V>(s.body + at);
  } else {
    std::memcpy(&value, s.body + at, sizeof value);
  }
  return value;
}

template <class E>
std::span<const E> span_at(const SampleState& s, Extent extent) noexcept {
  if (!extent) {
    s.flag_malformed();
    return {};
  }
  return {reinterpret_cast<const E*>(s.body + extent.first), extent.count};
}

inline std::string_view string_at(const SampleState& s, std::uint64_t offset) noexcept {
  const Extent text = checked_string(s, offset);
  if (!text) {
    s.flag_malformed();
    return {};
  }
  return {reinterpret_cast<const char*>(s.body + text.first), text.count};
}

struct StringStep {
  using Value = std::string_view;
  static constexpr const StructType* type = nullptr;
  static constexpr std::size_t leaf = 0;
  static Value read(const SampleState& s, std::uint64_t offset) { return string_at(s, offset); }
};

/// The range that a getter of several strings returns.
using StringRange = ElementRange<StringStep>;

template <auto R, class S, std::size_t Leaf>
class ElementPlace;

template <auto R, class S, std::size_t Leaf>
struct ElementStep {
  using Value = typename S::template View<ElementPlace<R, S, Leaf>>;
  static constexpr const StructType* type = &TypeTable<S>::type;
  static constexpr std::size_t leaf = Leaf;
  static Value read(const SampleState& s, std::uint64_t offset) {
    return Value{ElementPlace<R, S, Leaf>{&s, offset}};
  }
};

/// Returns the offset of the first element of member M, and the number of elements. The member begins at
/// `offset`.
inline Extent elements_of(const SampleState& s, const Member& m, std::uint64_t offset) noexcept {
  if (m.shape == Shape::sequence) return checked_length(s, offset);
  return {offset < no_offset ? static_cast<std::uint32_t>(offset) : no_offset, m.count};
}

/// Reads member number Index of struct S, whose first leaf is Leaf. The member begins at `offset`. `As` is
/// the nested struct or the enumeration that the generated code names; for other members it is void.
template <auto R, class S, std::size_t Index, std::size_t Leaf, class As>
auto read_leaf(const SampleState& s, std::uint64_t offset) {
  constexpr Member M = TypeTable<S>::members[Index];
  if constexpr (M.kind == Kind::structure) {
    constexpr std::size_t element_leaf = Leaf + (M.shape == Shape::sequence ? 1 : 0);
    return ElementRange<ElementStep<R, As, element_leaf>>{s, elements_of(s, M, offset)};
  } else if constexpr (M.kind == Kind::string) {
    if constexpr (M.shape == Shape::single) {
      return string_at(s, offset);
    } else {
      return StringRange{s, elements_of(s, M, offset)};
    }
  } else if constexpr (M.shape == Shape::single) {
    using V = std::conditional_t<std::is_enum_v<As>, As, ScalarOf<M.kind>>;
    return load<V>(s, offset);
  } else {
    using E = std::conditional_t<std::is_enum_v<As>, As, ElementOf<M.kind>>;
    if constexpr (M.shape == Shape::sequence) {
      if (s.parts != nullptr) [[unlikely]] {
        if (const auto part = bytes_in_place(s, Leaf))
          return std::span<const E>{reinterpret_cast<const E*>(part->data()), part->size() / sizeof(E)};
      }
    }
    return span_at<E>(s, M.shape == Shape::sequence
                             ? checked_sequence(s, offset, sizeof(E))
                             : Extent{checked_block(s, offset, M.count, sizeof(E)), M.count});
  }
}

/// This function is not inlined into the getters, which are many and short, since it is called only once
/// for each leaf and sample.
[[gnu::noinline]] inline bool note_first(const SampleState& s, std::size_t leaf,
                                         std::size_t leaves) noexcept {
  if (s.log == nullptr) return s.mask->any_of(leaf, leaves);
  const bool present = s.mask->any_of(leaf, leaves) && s.log->is_as_published(leaf, leaves);
  s.log->touch(leaf, present);
  return present;
}

template <class R>
struct RootOf;
template <class T>
struct RootOf<Req<T>> {
  using type = T;
};

/// The common base of both places: it determines whether a member can be read, and notes reads of members.
template <auto R, class S, std::size_t Leaf>
struct PlaceBase {
  using Root = typename RootOf<std::remove_const_t<decltype(R)>>::type;
  using Struct = S;
  static constexpr Mask<Root> declared = R.mask;
  /// True if the reader declared only a mask. With declared parts, fields that belong to the parts are
  /// sent, too.
  static constexpr bool declares_mask = !R.may_lack() && R.parts == DeclaredParts{};
  static constexpr bool may_lack = R.may_lack();
  static constexpr auto requirement = R;
  static constexpr std::size_t first_leaf = Leaf;
  /// True if the whole struct can be read.
  static constexpr bool has_whole = may_lack || R.mask.contains(R.mask.range(Leaf, leaf_count_of<S>));
  template <std::size_t M>
  static constexpr std::size_t leaf_of = Leaf + leaf_offset(TypeTable<S>::type, M);

  /// True if any leaf of member M is in the declared mask, or if no mask is declared.
  template <std::size_t M>
  static constexpr bool has = R.may_lack() || R.mask.intersects(leaf_of<M>,
                                                                leaf_count(TypeTable<S>::members[M]));
  /// True if all leaves of member M are in the declared mask, or if no mask is declared.
  template <std::size_t M>
  static constexpr bool has_all =
      R.may_lack() || R.mask.contains(R.mask.range(leaf_of<M>, leaf_count(TypeTable<S>::members[M])));

 protected:
  /// Notes the access if the reader records, and returns whether the sample has the leaf. For a sequence of
  /// structs, `leaf` is the leaf of its length; for an array of structs, it is the first leaf of its
  /// element.
  static bool note(const SampleState& s, std::size_t leaf, std::size_t leaves) noexcept {
    if constexpr (!R.is_recorded) return s.mask->any_of(leaf, leaves);
    return (s.log != nullptr && s.log->has_found(leaf)) || note_first(s, leaf, leaves);
  }

  template <std::size_t M, class As, class OffsetOf>
  static auto leaf_value(const SampleState& s, OffsetOf offset_of) {
    using V = decltype(read_leaf<R, S, M, leaf_of<M>, As>(s, 0));
    if constexpr (R.may_lack()) {
      if (!note(s, leaf_of<M>, leaf_count(TypeTable<S>::members[M]))) return Optional<V>{};
    }
    return Got<R, V>{read_leaf<R, S, M, leaf_of<M>, As>(s, offset_of())};
  }
};

/// A struct in a sample, and the offset at which it begins.
struct WholeStruct {
  const SampleState* sample;
  std::uint64_t begin;
};

/// The members of struct S, found through the index. Leaf and Slot are the first leaf and slot of S in the
/// root type.
template <auto R, class S, std::size_t Leaf, std::size_t Slot>
class IndexedPlace : public PlaceBase<R, S, Leaf> {
  using Base = PlaceBase<R, S, Leaf>;

 public:
  static constexpr bool is_indexed = true;

  explicit IndexedPlace(const SampleState* s) : s_(s) {}

  template <std::size_t M, class As = void>
  auto get() const {
    constexpr const Member& m = TypeTable<S>::members[M];
    if constexpr (m.kind == Kind::structure && m.shape == Shape::single) {
      using Place = IndexedPlace<R, As, Base::template leaf_of<M>, slot_of<M>>;
      return typename As::template View<Place>{Place{s_}};
    } else {
      return Base::template leaf_value<M, As>(*s_, [this] { return begin_of<M>(); });
    }
  }

  // These functions are used where several members are read at once (points.h, cells.h). They return the
  // sample, and the offset of member M in it. M must not be a single struct.
  const SampleState& state() const { return *s_; }
  template <std::size_t M>
  std::uint64_t begin_of() const {
    return __atomic_load_n(s_->index + slot_of<M>, __ATOMIC_RELAXED);
  }
  /// Returns the sample with the parts of its fields, and the offset of the struct in that sample. If there
  /// is no memory to put the parts together, the returned sample has no body.
  WholeStruct whole() const {
    const SampleState* const sample = s_->parts == nullptr ? s_ : &put_together(*s_);
    if (sample->body == nullptr) return {sample, no_offset};
    return {sample, __atomic_load_n(sample->index + Slot, __ATOMIC_RELAXED)};
  }

 private:
  template <std::size_t M>
  static constexpr std::size_t slot_of = Slot + slot_offset(TypeTable<S>::type, M);

  const SampleState* s_;
};

/// The members of one struct S inside a collection. The struct begins at an offset. A member is found by a
/// walk over the members before it.
template <auto R, class S, std::size_t Leaf>
class ElementPlace : public PlaceBase<R, S, Leaf> {
  using Base = PlaceBase<R, S, Leaf>;

 public:
  static constexpr bool is_indexed = false;

  ElementPlace(const SampleState* s, std::uint64_t offset) : s_(s), offset_(offset) {}

  template <std::size_t M, class As = void>
  auto get() const {
    constexpr const Member& m = TypeTable<S>::members[M];
    if constexpr (m.kind == Kind::structure && m.shape == Shape::single) {
      using Place = ElementPlace<R, As, Base::template leaf_of<M>>;
      return typename As::template View<Place>{Place{s_, begin_of<M>()}};
    } else {
      return Base::template leaf_value<M, As>(*s_, [this] { return begin_of<M>(); });
    }
  }

  // These functions have the same meaning as in IndexedPlace.
  const SampleState& state() const { return *s_; }
  template <std::size_t M>
  std::uint64_t begin_of() const {
    return member_begin(*s_, TypeTable<S>::type, M, Leaf, offset_);
  }
  /// Returns the sample itself, since fields of elements have no parts.
  WholeStruct whole() const { return {s_, offset_}; }

 private:
  const SampleState* s_;
  std::uint64_t offset_;
};

/// The type of the view of a whole sample of type T for a reader with requirement R. (Pass R through a
/// parameter of type Req<T> in an alias template: g++ 12 crashes on a mask variable there.)
template <class T, Req<T> R>
using ViewOf = typename T::template View<IndexedPlace<R, T, 0, 0>>;

template <class T, Req<T> R>
ViewOf<T, R> view_of(const SampleState& s) {
  return ViewOf<T, R>{IndexedPlace<R, T, 0, 0>{&s}};
}

}  // namespace sft::detail
