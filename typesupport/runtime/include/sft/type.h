// The structure of a message type: its members with their names, kinds, shapes and units. A program that
// handles types with which it was not compiled walks this tree. For example, `sft type` prints it, and a
// program can make a table of columns from it. TypeSupport::type(), DynamicType::type() and DynamicView lead
// to it.
//
// Generated code and DynamicType make these structs; a program only reads them. All of them are immutable,
// so that any thread may read them at any time. The structs of a compiled type live as long as the program.
// The structs of a DynamicType live as long as any copy of it. The pointers, spans and texts in them have
// the same lifetime.
//
// Leaves are the units in which fields are requested and sent. They are counted depth-first: a primitive, a
// string, and an array or a sequence of those is one leaf each; a nested struct has the leaves of its
// members; an array of structs has those of its element; a sequence of structs has one leaf for its length,
// followed by those of its element.
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

  std::string_view name;                    ///< for example "my_pkg::msg::Color"
  bool is_bitmask;                          ///< false: an enumeration
  std::span<const Enumerator> enumerators;  ///< at least one
};

/// A message type, or a struct that is nested in one.
struct StructType {
  /// One member of a struct.
  struct Member {
    /// The type of one element, as IDL names it.
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

    std::string_view name;             ///< the name in the IDL
    Kind kind{};                       ///< the kind of one element; of an enumeration, that of its integer
    Shape shape{};                     ///< the shape of the member
    std::uint32_t count = 1;           ///< the elements of an array, over all its dimensions; otherwise 1
    std::uint32_t bound = 0;           ///< the maximum number of elements of a sequence; 0: unbounded
    std::uint32_t string_bound = 0;    ///< the most characters of each string without NUL; 0: unbounded
    const StructType* type = nullptr;  ///< the element's type if the kind is structure, otherwise null
    const EnumType* enumeration = nullptr;  ///< the enumeration; null: it is only an integer
    std::size_t offset = 0;  ///< the offset in the compiled struct; 0 in a DynamicType, as the next two
    std::size_t stride = 0;  ///< the distance of two elements in the compiled struct
    const detail::SequenceAccess* access = nullptr;  ///< reads a compiled std::vector; only of a sequence
    bool key = false;                                ///< true for `@key`: the member is always sent
    std::string_view unit{};                         ///< the text of `@unit`, to be shown to people
    std::string_view layout{};  ///< the rule of `@sft_layout`: how it has rows and columns (selection.md)
  };

  std::string_view name;            ///< for example "sensor_msgs::msg::PointCloud2"
  std::span<const Member> members;  ///< the members in the order of the IDL; at least one
  std::size_t leaves = 0;           ///< the number of leaves that a mask can select in it

  // The members from here on are for SFT's own code.
  std::size_t index_slots = 0;  ///< offsets in a sample's index (detail/type_table.h)
  /// Size of a packed struct, such as a point: CDR always encodes it as that many bytes, without padding,
  /// from the next multiple of `alignment` on. A packed struct has no strings, sequences or booleans, since
  /// these have to be checked. 0 for other structs.
  std::uint32_t packed_bytes = 0;
  std::uint32_t alignment = 1;       ///< the largest alignment of all primitives and lengths in it
  bool is_packed_in_memory = false;  ///< true: packed, and the compiled struct has the same bytes
  /// Only in a DynamicType: the first leaf of each member, counted from the first leaf of the struct. With
  /// it a walk finds the members with selected leaves and does not look at all other members. A type that
  /// was received may have very many members.
  std::span<const std::uint32_t> first_leaves{};

  constexpr StructType() = default;
  /// Counts leaves and slots and finds the packing. Both arguments outlive the struct. Defined in
  /// detail/type_table.h.
  constexpr StructType(std::string_view name, std::span<const Member> members);

 private:
  constexpr void find_packing();
};

/// The number of leaves of a struct or of a member.
constexpr std::size_t leaf_count(const StructType& type) { return type.leaves; }
constexpr std::size_t leaf_count(const StructType::Member& m) {
  using enum StructType::Member::Kind;
  if (m.kind != structure) return 1;
  return m.type->leaves + (m.shape == StructType::Member::Shape::sequence ? 1 : 0);
}

}  // namespace sft
