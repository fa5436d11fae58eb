// The description of a message type that everything at run time works from: a constexpr tree of members that
// the IDL compiler emits (names, kinds, places in the owned struct) and the numbering that is computed from
// it.
//
// Numbering. Leaves are counted depth-first: a primitive, a string, an array or a sequence of those is one
// leaf; a nested struct contributes the leaves of its members; an array of structs those of its element; a
// sequence of structs one leaf for its length followed by those of its element. Slots are the leaves that a
// sample's index has an offset for: every leaf outside collections of structs, and one slot for each
// outermost collection of structs.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace sft {

enum class Kind : std::uint8_t {
  boolean,
  octet,
  character,
  int8,
  uint8,
  int16,
  uint16,
  int32,
  uint32,
  int64,
  uint64,
  float32,
  float64,
  string,
  structure
};

enum class Shape : std::uint8_t { single, array, sequence };

/// Bytes that one primitive takes in CDR, which is also its alignment (XCDR1). A string's is that of its
/// length.
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

/// How to reach the elements of one std::vector instantiation without knowing its element type.
struct SequenceAccess {
  std::size_t (*size)(const void* vector);
  const void* (*data)(const void* vector);
  void* (*resize)(void* vector, std::size_t elements);  ///< returns the first element; existing ones are kept
};

/// One name of an enumeration with its value, or one flag of a bitmask with its bit set.
struct Enumerator {
  std::string_view name;
  std::uint64_t value;
};

struct EnumType {
  std::string_view name;  ///< "my_pkg::msg::Color"
  bool is_bitmask;
  std::span<const Enumerator> enumerators;
};

/// Specialised for every generated enumeration: `static constexpr EnumType type`.
template <class E>
struct EnumTable;

struct StructType;

struct Member {
  std::string_view name;
  Kind kind{};  ///< of one element
  Shape shape{};
  std::uint32_t count = 1;                ///< elements of an array (all dimensions); 1 otherwise
  std::uint32_t bound = 0;                ///< most elements of a sequence; 0: unbounded
  std::uint32_t string_bound = 0;         ///< most characters of each string, without NUL; 0: unbounded
  const StructType* type = nullptr;       ///< the element's type where kind is structure
  const EnumType* enumeration = nullptr;  ///< what the integer stands for, if it is an enumeration or bitmask
  std::size_t offset = 0;                 ///< of the member in the owned struct
  std::size_t stride = 0;                 ///< of one element in the owned struct
  const SequenceAccess* access = nullptr;  ///< where shape is sequence
  bool key = false;
  std::string_view unit{};  ///< from @unit, for display
};

struct StructType {
  std::string_view name;  ///< "sensor_msgs::msg::PointCloud2"
  std::span<const Member> members;
  std::size_t leaves = 0;
  std::size_t slots = 0;

  /// Of a packed struct, such as a point: one that CDR always encodes as that many bytes, without padding,
  /// from the next multiple of `alignment` on. It has neither strings nor sequences nor booleans, which would
  /// have to be looked at. 0 of others.
  std::uint32_t packed_bytes = 0;
  std::uint32_t alignment = 1;       ///< the largest of all primitives and lengths below
  bool is_packed_in_memory = false;  ///< and the owned struct has the very same bytes

  /// Of a type that was not compiled in: first leaf of each member, counted from the first leaf of the
  /// struct. Then walks find the members of which something is selected without looking at all others: nobody
  /// vouches that those are few.
  std::span<const std::uint32_t> first_leaves{};

  constexpr StructType() = default;
  constexpr StructType(std::string_view name, std::span<const Member> members);

 private:
  constexpr void find_packing();
};

/// Specialised for every generated type: `static constexpr StructType type`.
template <class T>
struct TypeTable;

constexpr bool is_collection(const Member& m) {
  return m.kind == Kind::structure && m.shape != Shape::single;
}

constexpr std::size_t leaf_count(const StructType& type) { return type.leaves; }
constexpr std::size_t leaf_count(const Member& m) {
  if (m.kind != Kind::structure) return 1;
  return m.type->leaves + (m.shape == Shape::sequence ? 1 : 0);
}

constexpr std::size_t slot_count(const StructType& type) { return type.slots; }
constexpr std::size_t slot_count(const Member& m) {
  return m.kind == Kind::structure && m.shape == Shape::single ? m.type->slots : 1;
}

constexpr StructType::StructType(std::string_view type_name, std::span<const Member> type_members)
    : name(type_name), members(type_members) {
  for (const Member& m : members) {
    leaves += leaf_count(m);
    slots += slot_count(m);
  }
  find_packing();
}

constexpr std::uint32_t alignment_of(const Member& m) {
  const std::uint32_t own =
      m.kind == Kind::structure ? m.type->alignment : static_cast<std::uint32_t>(size_of(m.kind));
  return m.shape == Shape::sequence && own < 4 ? 4 : own;
}

/// Of where a member begins and its slot points to. A collection of structs without a length begins with its
/// first element, which has no alignment of its own.
constexpr std::size_t slot_alignment(const Member& m) {
  if (m.shape == Shape::sequence) return 4;
  return m.kind == Kind::structure ? 1 : size_of(m.kind);
}

/// Of one element; 0 if it has to be looked at.
constexpr std::uint32_t packed_bytes_of(const Member& m) {
  if (m.kind == Kind::structure) return m.type->packed_bytes;
  return is_primitive(m.kind) && m.kind != Kind::boolean ? static_cast<std::uint32_t>(size_of(m.kind)) : 0;
}

constexpr void StructType::find_packing() {
  std::uint64_t bytes = 0;
  bool is_packed = !members.empty();
  bool is_same_in_memory = true;
  for (const Member& m : members) {
    const std::uint32_t own = packed_bytes_of(m);
    is_packed = is_packed && own != 0 && m.shape != Shape::sequence && bytes % alignment_of(m) == 0;
    is_same_in_memory = is_same_in_memory && m.offset == bytes && m.stride == own &&
                        (m.kind != Kind::structure || m.type->is_packed_in_memory);
    if (alignment_of(m) > alignment) alignment = alignment_of(m);
    bytes += std::uint64_t{m.count} * own;
    if (bytes >> 32 != 0) {  // before a sum of more overflows
      is_packed = false;
      bytes = 0;
    }
  }
  // Without padding in front of it wherever it stands, and none between two of them.
  if (!is_packed || alignment_of(members[0]) != alignment || bytes % alignment != 0) return;
  packed_bytes = static_cast<std::uint32_t>(bytes);
  is_packed_in_memory = is_same_in_memory;
}

/// First leaf of a member, counted from the first leaf of its struct.
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

/// A value of the owned struct's member type V is described without naming its shape twice: it follows from
/// V.
namespace detail {

template <class V>
struct SequenceAccessOf {
  static constexpr SequenceAccess access{
      [](const void* v) { return static_cast<const V*>(v)->size(); },
      [](const void* v) { return static_cast<const void*>(static_cast<const V*>(v)->data()); },
      [](void* v, std::size_t n) {
        static_cast<V*>(v)->resize(n);
        return static_cast<void*>(static_cast<V*>(v)->data());
      }};
};

template <class V>
struct ShapeOf {
  using Element = V;
  static constexpr Shape shape = Shape::single;
  static constexpr std::uint32_t count = 1;
  static constexpr const SequenceAccess* access = nullptr;
};

template <class E, std::size_t N>
struct ShapeOf<std::array<E, N>> {
  using Element = typename ShapeOf<E>::Element;
  static_assert(ShapeOf<E>::shape != Shape::sequence,
                "an array of sequences needs a struct around the sequence");
  static constexpr Shape shape = Shape::array;
  static constexpr std::uint32_t count = N * ShapeOf<E>::count;
  static constexpr const SequenceAccess* access = nullptr;
};

template <class E>
struct ShapeOf<std::vector<E>> {
  using Element = E;
  static_assert(ShapeOf<E>::shape == Shape::single,
                "a sequence of collections needs a struct around the inner one");
  static constexpr Shape shape = Shape::sequence;
  static constexpr std::uint32_t count = 1;
  static constexpr const SequenceAccess* access = &SequenceAccessOf<std::vector<E>>::access;
};

template <class E>
constexpr const StructType* struct_type_of() {
  if constexpr (std::is_class_v<E> && !std::is_same_v<E, std::string>) {
    return &TypeTable<E>::type;
  } else {
    return nullptr;
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

}  // namespace detail

struct MemberOptions {
  std::uint32_t bound = 0;
  std::uint32_t string_bound = 0;
  bool key = false;
  std::string_view unit{};
};

/// One row of a generated table. V is the member's type in the owned struct, `kind` that of one element in
/// IDL (it tells octet from uint8 and a sequence of booleans, held as std::uint8_t, from one of octets).
template <class V>
constexpr Member member(std::string_view name, Kind kind, std::size_t offset, MemberOptions options = {}) {
  using Place = detail::ShapeOf<V>;
  using Element = typename Place::Element;
  return {.name = name,
          .kind = kind,
          .shape = Place::shape,
          .count = Place::count,
          .bound = options.bound,
          .string_bound = options.string_bound,
          .type = detail::struct_type_of<Element>(),
          .enumeration = detail::enum_type_of<Element>(),
          .offset = offset,
          .stride = sizeof(Element),
          .access = Place::access,
          .key = options.key,
          .unit = options.unit};
}

}  // namespace sft
