// The places of the cells of a field in a sample, in rows and columns, and the functions that find them.
// The bytes may be hostile, and in shared memory they may change while they are read. So each number of the
// header is read once, checked, and stored in the grid.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "sft/detail/layout.h"
#include "sft/detail/walk.h"
#include "sft/mask.h"
#include "sft/result.h"

namespace sft {

class DynamicView;

namespace detail {

class Cut;

/// Rows of cells, all within the bytes of the field.
struct CellGrid {
  const std::byte* first = nullptr;  ///< address of the first cell
  std::uint64_t row_step = 1;        ///< distance of two rows in bytes; never 0, not even in an empty grid
  std::uint32_t column_step = 0;     ///< distance of two cells of a row in bytes
  std::uint32_t rows = 0;
  std::uint32_t columns = 0;
  bool is_swapped = false;  ///< true if the byte order of the values is not that of this machine

  /// Returns the cells of a part in the larger sample `source`, at the places in `cut`.
  static CellGrid of(const SampleState& source, const Cut& cut);

  std::size_t size() const { return std::size_t{rows} * columns; }
  std::uint64_t row_bytes() const { return std::uint64_t{columns} * column_step; }
  /// Returns true if the distance between neighbouring cells is the same everywhere, also between the last
  /// cell of a row and the first cell of the next row.
  bool is_joined() const { return rows <= 1 || row_step == row_bytes(); }
  const std::byte* at(std::uint64_t row, std::uint64_t column) const {
    return first + row * row_step + column * column_step;
  }

  /// Returns these cells in as few rows as possible: rows without bytes between them are joined. In the
  /// result, no step and no number of columns is 0. Only an empty grid has 0 rows.
  CellGrid joined() const {
    if (size() == 0) return {.column_step = 1, .columns = 1};
    if (!is_joined()) return *this;
    CellGrid grid = *this;
    grid.columns = static_cast<std::uint32_t>(size());
    grid.rows = 1;
    grid.row_step = grid.row_bytes();
    return grid;
  }
};

/// The place of a sequence of numbers in a sample.
struct CellsPlace {
  const SampleState* sample = nullptr;
  /// The mask that the reader declared; null: all fields that the sample has.
  const FieldMask* declared = nullptr;
  const Layout* layout = nullptr;  ///< layout in the type of this sample; null: the elements are one row
  const Member* member = nullptr;
  std::size_t leaf = 0;
  std::uint64_t offset = 0;  ///< the offset of the field in the body
};

/// Finds the cells, which must have a size of `cell_bytes`. If reads are recorded, notes which fields the
/// function reads.
Result<CellGrid> find_cells(const CellsPlace& place, std::size_t cell_bytes);

/// Finds the cells of the field with this path in a message whose type is not compiled in. `holds` returns
/// true if elements of that kind may be read as the cells.
Result<CellGrid> find_cells(const DynamicView& message, std::string_view path, std::size_t cell_bytes,
                            bool (*holds)(Kind));

}  // namespace detail
}  // namespace sft
