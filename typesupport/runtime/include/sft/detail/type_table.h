// Makes the structure of a message type (type.h) from generated tables, and computes its numbering.
//
// Slots are the leaves for which a sample's index has an offset: every leaf outside collections of structs,
// and one slot for each outermost collection of structs.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "sft/type.h"

namespace sft::detail {

using Member = StructType::Member;
using Kind = Member::Kind;
using Shape = Member::Shape;
using Enumerator = EnumType::Enumerator;

/// Returns the number of bytes of one primitive in CDR, which is also its alignment (XCDR1). For a string,
/// returns the number of bytes of its length.
constexpr std::size_t size_of(Kind kind) {
  switch (kind) {
    case Kind::boolean:
    case Kind::octet:
    case Kind::character:
    case Kind::int8:
    case Kind::uint8:
      return 1;
    case Kind::int16:
    case Kind::uint16:
      return 2;
    case Kind::int32:
    case Kind::uint32:
    case Kind::float32:
    case Kind::string:
      return 4;
    case Kind::int64:
    case Kind::uint64:
    case Kind::float64:
      return 8;
    case Kind::structure:
      return 0;
  }
  return 0;
}

constexpr bool is_primitive(Kind kind) { return kind < Kind::string; }

/// Accesses the elements of one type of vector without knowing its element type.
struct SequenceAccess {
  std::size_t bytes;  ///< the size of the vector itself
  std::size_t (*size)(const void* vector);
  /// Returns the first element. Null for a std::vector<bool>, whose elements have no addresses.
  const void* (*data)(const void* vector);
  /// Returns the first element, or null for a std::vector<bool>; existing elements are kept.
  void* (*resize)(void* vector, std::size_t elements);
  // Only for a std::vector<bool>:
  bool (*get)(const void* vector, std::size_t element) = nullptr;
  void (*set)(void* vector, std::size_t element, bool value) = nullptr;
};

/// Specialised for every generated enumeration, with `static constexpr EnumType type`.
template <class E>
struct EnumTable;

/// Specialised for every generated type, with `static constexpr StructType type`. Its `members_in<S>`
/// describes the same members at their places in another struct S (struct_in.h).
template <class T>
struct TypeTable;

/// A message in an object of the program.
struct Message {
  const StructType& type;  ///< has the places of the members in that object
  const void* value;
};

constexpr bool is_collection(const Member& m) {
  return m.kind == Kind::structure && m.shape != Shape::single;
}

constexpr std::size_t slot_count(const StructType& type) { return type.index_slots; }
constexpr std::size_t slot_count(const Member& m) {
  return m.kind == Kind::structure && m.shape == Shape::single ? m.type->index_slots : 1;
}

constexpr std::uint32_t alignment_of(const Member& m) {
  const std::uint32_t own =
      m.kind == Kind::structure ? m.type->alignment : static_cast<std::uint32_t>(size_of(m.kind));
  return m.shape == Shape::sequence && own < 4 ? 4 : own;
}

/// Returns the alignment of the position to which the slot of a member points. An array of structs begins
/// with its first element, which has no alignment of its own.
constexpr std::size_t slot_alignment(const Member& m) {
  if (m.shape == Shape::sequence) return 4;
  return m.kind == Kind::structure ? 1 : size_of(m.kind);
}

/// Returns the number of packed bytes of one element (StructType::packed_bytes); 0 if each element has to
/// be visited.
constexpr std::uint32_t packed_bytes_of(const Member& m) {
  if (m.kind == Kind::structure) return m.type->packed_bytes;
  return is_primitive(m.kind) && m.kind != Kind::boolean ? static_cast<std::uint32_t>(size_of(m.kind)) : 0;
}

}  // namespace sft::detail

namespace sft {

constexpr StructType::StructType(std::string_view type_name, std::span<const Member> type_members)
    : name(type_name), members(type_members) {
  for (const Member& m : members) {
    leaves += leaf_count(m);
    index_slots += detail::slot_count(m);
  }
  find_packing();
}

constexpr void StructType::find_packing() {
  std::uint64_t bytes = 0;
  bool is_packed = !members.empty();
  bool is_same_in_memory = true;
  for (const Member& m : members) {
    const std::uint32_t own = detail::packed_bytes_of(m);
    is_packed =
        is_packed && own != 0 && m.shape != Member::Shape::sequence && bytes % detail::alignment_of(m) == 0;
    is_same_in_memory = is_same_in_memory && m.offset == bytes && m.stride == own &&
                        (m.kind != Member::Kind::structure || m.type->is_packed_in_memory);
    if (detail::alignment_of(m) > alignment) alignment = detail::alignment_of(m);
    bytes += std::uint64_t{m.count} * own;
    if (bytes >> 32 != 0) {  // stops before the sum of further members overflows
      is_packed = false;
      bytes = 0;
    }
  }
  // A packed struct never needs padding before it or between two of them.
  if (!is_packed || detail::alignment_of(members[0]) != alignment || bytes % alignment != 0) return;
  packed_bytes = static_cast<std::uint32_t>(bytes);
  is_packed_in_memory = is_same_in_memory;
}

}  // namespace sft

namespace sft::detail {

/// Returns the first leaf of a member, counted from the first leaf of its struct.
constexpr std::size_t leaf_offset(const StructType& type, std::size_t member) {
  std::size_t n = 0;
  for (std::size_t i = 0; i < member; ++i) n += leaf_count(type.members[i]);
  return n;
}

constexpr std::size_t slot_offset(const StructType& type, std::size_t member) {
  std::size_t n = 0;
  for (std::size_t i = 0; i < member; ++i) n += slot_count(type.members[i]);
  return n;
}

template <class T>
inline constexpr std::size_t leaf_count_of = leaf_count(TypeTable<T>::type);

/// Returns the first element, or null. ROS 2's BoundedVector has no data() that could be called.
template <class V>
constexpr auto first_of(V& vector) {
  if constexpr (requires { vector.data(); }) {
    return vector.data();
  } else {
    return vector.empty() ? nullptr : &vector.front();
  }
}

template <class V>
constexpr SequenceAccess sequence_access() {
  SequenceAccess access{};
  access.bytes = sizeof(V);
  access.size = [](const void* v) -> std::size_t { return static_cast<const V*>(v)->size(); };
  if constexpr (std::is_same_v<typename V::reference, typename V::value_type&>) {
    access.data = [](const void* v) -> const void* { return first_of(*static_cast<const V*>(v)); };
    access.resize = [](void* v, std::size_t n) -> void* {
      static_cast<V*>(v)->resize(n);
      return first_of(*static_cast<V*>(v));
    };
  } else {
    access.resize = [](void* v, std::size_t n) -> void* { return static_cast<V*>(v)->resize(n), nullptr; };
    access.get = [](const void* v, std::size_t i) -> bool { return (*static_cast<const V*>(v))[i]; };
    access.set = [](void* v, std::size_t i, bool value) { (*static_cast<V*>(v))[i] = value; };
  }
  return access;
}

template <class V>
struct SequenceAccessOf {
  static constexpr SequenceAccess access = sequence_access<V>();
};

template <class V>
struct ShapeOf {
  using Element = V;
  static constexpr Shape shape = Shape::single;
  static constexpr std::uint32_t count = 1;
  static constexpr std::uint32_t bound = 0;
  static constexpr const SequenceAccess* access = nullptr;
};

template <class E, std::size_t N>
struct ShapeOf<std::array<E, N>> {
  using Element = typename ShapeOf<E>::Element;
  static_assert(ShapeOf<E>::shape != Shape::sequence,
                "an array of sequences needs a struct around the sequence");
  static constexpr Shape shape = Shape::array;
  static constexpr std::uint32_t count = N * ShapeOf<E>::count;
  static constexpr std::uint32_t bound = 0;
  static constexpr const SequenceAccess* access = nullptr;
};

template <class V, class E, std::size_t Bound>
struct SequenceShape {
  using Element = E;
  static_assert(ShapeOf<E>::shape == Shape::single,
                "a sequence of collections needs a struct around the inner one");
  static constexpr Shape shape = Shape::sequence;
  static constexpr std::uint32_t count = 1;
  static constexpr std::uint32_t bound = Bound;  ///< the bound that the C++ type has itself; 0: none
  static constexpr const SequenceAccess* access = &SequenceAccessOf<V>::access;
};

template <class E, class Allocator>
struct ShapeOf<std::vector<E, Allocator>> : SequenceShape<std::vector<E, Allocator>, E, 0> {};

/// A vector with a bound, as rosidl_runtime_cpp::BoundedVector.
template <template <class, std::size_t, class> class Vector, class E, std::size_t Bound, class Allocator>
struct ShapeOf<Vector<E, Bound, Allocator>> : SequenceShape<Vector<E, Bound, Allocator>, E, Bound> {};

/// Says where the members of T lie in the struct S, which has the same members (struct_in.h).
template <class T, class S>
struct StructIn;

/// Returns the type of a nested struct T, which is an S in memory.
template <class T, class S>
constexpr const StructType* struct_type_of() {
  if constexpr (!std::is_class_v<T> || std::is_same_v<T, std::string>) {
    return nullptr;
  } else if constexpr (std::is_same_v<T, S>) {
    return &TypeTable<T>::type;
  } else {
    return &StructIn<T, S>::type;
  }
}

template <class E>
constexpr const EnumType* enum_type_of() {
  if constexpr (std::is_enum_v<E>) {
    return &EnumTable<E>::type;
  } else {
    return nullptr;
  }
}

struct MemberOptions {
  std::uint32_t bound = 0;
  std::uint32_t string_bound = 0;
  bool key = false;
  std::string_view unit{};
  std::string_view layout{};
};

/// Refuses to compile if a member of type M differs in more than its C++ type from the member V of the
/// message (struct_in.h).
template <class V, class M>
struct SameMember;

/// Makes one row of a generated table. V is the member's type in the owned struct, and M the type of the
/// same member in the struct that the table describes. `kind` is the kind of one element in IDL. It is
/// needed to distinguish octet from uint8, and a sequence of booleans, held as std::uint8_t, from a sequence
/// of octets.
template <class V, class M = V>
constexpr Member member(std::string_view name, Kind kind, std::size_t offset, MemberOptions options = {}) {
  using Place = ShapeOf<M>;
  using Element = typename Place::Element;
  using OwnElement = typename ShapeOf<V>::Element;
  if constexpr (!std::is_same_v<V, M>) SameMember<V, M>::refuse_bool_unless(kind);
  const bool is_narrower = Place::bound != 0 && (options.bound == 0 || Place::bound < options.bound);
  return {.name = name,
          .kind = kind,
          .shape = Place::shape,
          .count = Place::count,
          .bound = is_narrower ? Place::bound : options.bound,
          .string_bound = options.string_bound,
          .type = struct_type_of<OwnElement, Element>(),
          .enumeration = enum_type_of<OwnElement>(),
          .offset = offset,
          .stride = sizeof(Element),
          .access = Place::access,
          .key = options.key,
          .unit = options.unit,
          .layout = options.layout};
}

}  // namespace sft::detail
