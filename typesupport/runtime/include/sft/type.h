// The structure of a message type: its members with their names, kinds, shapes and units. A program that
// handles types with which it was not compiled walks this tree. For example, `sft type` prints the tree,
// and a program can make a table of columns from it. TypeSupport::type(), DynamicType::type() and
// DynamicView give access to the tree.
//
// Generated code and DynamicType make these structs; a program only reads them. All of them are immutable,
// so that any thread may read them at any time. The structs of a compiled type live as long as the program.
// The structs of a DynamicType live as long as any copy of it. The pointers, spans and texts in them have
// the same lifetime.
//
// Leaves are the units in which fields are requested and sent. They are counted depth-first. A primitive, a
// string, and an array or a sequence of primitives or strings is one leaf each. A nested struct has the
// leaves of its members. An array of structs has the leaves of its element. A sequence of structs has one
// leaf for its length, followed by the leaves of its element.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace sft {

namespace detail {
struct SequenceAccess;
}

/// An enumeration or a bitmask.
struct EnumType {
  /// One name of an enumeration with its value, or one flag of a bitmask with its bit set.
  struct Enumerator {
    std::string_view name;  ///< the name in the IDL
    std::uint64_t value;    ///< for a flag, a number with its bit set
  };

  std::string_view name;                    ///< the name of the type, such as "my_pkg::msg::Color"
  bool is_bitmask;                          ///< false: the type is an enumeration
  std::span<const Enumerator> enumerators;  ///< the names; there is at least one
};

/// A message type, or a struct that is nested in one.
struct StructType {
  /// One member of a struct.
  struct Member {
    /// The type of one element, by its name in IDL.
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
    /// The number of elements of a member: one, a fixed number, or a variable number.
    enum class Shape : std::uint8_t { single, array, sequence };

    std::string_view name;  ///< the name in the IDL
    /// The kind of one element; for an enumeration, the kind of its integer.
    Kind kind{};
    Shape shape{};  ///< the shape of the member
    /// The number of elements of an array, over all its dimensions; otherwise 1.
    std::uint32_t count = 1;
    std::uint32_t bound = 0;  ///< the maximum number of elements of a sequence; 0: unbounded
    /// The maximum number of characters of each string without NUL; 0: unbounded.
    std::uint32_t string_bound = 0;
    const StructType* type = nullptr;       ///< the element's type if the kind is structure, otherwise null
    const EnumType* enumeration = nullptr;  ///< the enumeration; null: the integer is no enumeration
    /// The offset in the compiled struct; in a DynamicType 0, like the next two members.
    std::size_t offset = 0;
    std::size_t stride = 0;  ///< the distance of two elements in the compiled struct, in bytes
    /// Reads a compiled std::vector; set only for a sequence.
    const detail::SequenceAccess* access = nullptr;
    bool key = false;           ///< true for `@key`: the member is always sent
    std::string_view unit{};    ///< the text of `@unit`, for output to people
    std::string_view layout{};  ///< the rule of `@sft_layout`, which defines rows and columns (selection.md)
  };

  std::string_view name;            ///< the name of the type, such as "sensor_msgs::msg::PointCloud2"
  std::span<const Member> members;  ///< the members in the order of the IDL; there is at least one
  std::size_t leaves = 0;           ///< the number of leaves of the struct that a mask can select

  // The following members are for SFT's own code.
  std::size_t index_slots = 0;  ///< number of offsets in a sample's index (detail/type_table.h)
  /// Size of a packed struct, such as a point. CDR always encodes such a struct with this number of bytes,
  /// without padding, from the next multiple of `alignment` on. A packed struct has no strings, sequences
  /// or booleans, since these have to be checked. 0 for other structs.
  std::uint32_t packed_bytes = 0;
  std::uint32_t alignment = 1;  ///< the largest alignment of all primitives and lengths in the struct
  /// True: the struct is packed, and the compiled struct has the same bytes.
  bool is_packed_in_memory = false;
  /// Only in a DynamicType: the first leaf of each member, counted from the first leaf of the struct. With
  /// these numbers a walk finds the members with selected leaves without visiting all other members. A type
  /// that was received may have very many members.
  std::span<const std::uint32_t> first_leaves{};

  constexpr StructType() = default;
  /// Counts leaves and slots and determines the packing. Both arguments must outlive the struct. Defined in
  /// detail/type_table.h.
  constexpr StructType(std::string_view name, std::span<const Member> members);

 private:
  constexpr void find_packing();
};

/// Returns the number of leaves of a struct or of a member.
constexpr std::size_t leaf_count(const StructType& type) { return type.leaves; }
constexpr std::size_t leaf_count(const StructType::Member& m) {
  using enum StructType::Member::Kind;
  if (m.kind != structure) return 1;
  return m.type->leaves + (m.shape == StructType::Member::Shape::sequence ? 1 : 0);
}

}  // namespace sft
