// The layout of a field: how it is made of rows and columns, and which other fields depend on it
// (selection.md, "Parts").
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "sft/detail/type_table.h"

namespace sft::detail {

/// The role of a field in the layout of another field, which can be taken in part.
enum class LayoutRole : std::uint8_t {
  rows,        ///< the number of rows; uint32, like the next three roles
  columns,     ///< the number of columns of a row
  cell_bytes,  ///< bytes from one cell of a row to the next
  row_bytes,   ///< bytes from one row to the next
  channels,    ///< a sequence of structs: string name, u32 offset, u8 type, u32 count
  byte_order,  ///< not rewritten, but needed to read the cells
  encoding,    ///< a string: the name of the format of a pixel
  scale,       ///< the length of a side of a cell
  /// A struct of seven float64: the position of the first cell (x, y, z), and its rotation (x, y, z, w).
  origin,
  first,    ///< the value that belongs to the first element
  last,     ///< the value that belongs to the last element
  step,     ///< the difference between the values of two neighbouring elements
  interval  ///< the time between two neighbouring elements
};
inline constexpr std::size_t layout_roles = 13;

/// The layout of a field in a type, with the places of the fields that belong to it.
struct Layout {
  enum class Form : std::uint8_t {
    list,   ///< a list: a number of elements, without rows
    cells,  ///< a grid: rows of cells, all of the same size
    points  ///< a cloud: rows of cells with channels
  };
  struct Field {
    std::uint32_t leaf = 0;  ///< the first leaf of the field
    std::uint32_t slot = 0;
    const Member* member = nullptr;  ///< the member with the role; null: the type has no such member
    explicit operator bool() const { return member != nullptr; }
  };

  Form form = Form::list;
  std::uint32_t rule = 0;     ///< value of Selection::Part::rule for its parts; 0: the rule was not annotated
  std::vector<Field> data{};  ///< all sequences of which the same part is taken
  std::array<Field, layout_roles> fields{};

  const Field& operator[](LayoutRole role) const { return fields[static_cast<std::size_t>(role)]; }
  /// Returns the role of the field with this leaf. The role origin is returned for the leaves of its position
  /// only.
  std::optional<LayoutRole> role_of(std::size_t leaf) const;
  bool has_rows() const { return form != Form::list; }
  bool has_channels() const { return form == Form::points; }
};

/// Returns the field with this leaf, which must exist and must not be in an array or sequence of structs.
Layout::Field field_at(const StructType& type, std::size_t leaf);

/// Returns the layouts of a type and of the structs in it, except those in arrays and sequences. Layouts
/// are annotated at members, or known by the name of the type. No field has a role in two layouts.
std::vector<Layout> layouts_of(const StructType& type);

}  // namespace sft::detail
