// The places of the points of a cloud and of the cells of a field in memory, for programs that do not know
// the types when they are compiled, such as bindings of other languages. Nothing is copied. The values are
// those that points_of() (points.h) and cells_of() (cells.h) read, with the same errors, and reads are
// recorded in the same way.
//
// All pointers are valid as long as the sample. Any thread may call these functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "sft/dynamic_view.h"
#include "sft/result.h"
#include "sft/type.h"

namespace sft {

/// Equal cells in rows and columns. Cell (r, c) begins at first + r * row_step + c * column_step, which may
/// be unaligned.
struct Strides {
  /// One channel of the points: `count` numbers of this kind, at this offset in a cell.
  struct Channel {
    StructType::Member::Kind kind{};  ///< int8 to uint32, float32 or float64
    std::uint32_t offset = 0;         ///< bytes from the beginning of the point
    std::uint32_t count = 1;          ///< at least 1
  };

  const std::byte* first = nullptr;  ///< the first cell; must not be read if there are no cells
  std::size_t rows = 0;              ///< the number of rows
  std::size_t columns = 0;           ///< the number of cells in each row
  std::size_t row_step = 0;          ///< bytes from one row to the next
  std::size_t column_step = 0;       ///< bytes from one cell of a row to the next
  bool is_swapped = false;           ///< true if the values have the other byte order than this host
  /// The channels in the order in which they were asked for; empty unless point_strides_of() has returned
  /// this object.
  std::vector<Channel> channels{};
};

/// Returns the cells of the field with this path. Each has `cell_bytes` bytes: an element of the field, or a
/// pixel.
Result<Strides> strides_of(const DynamicView& message, std::string_view path, std::size_t cell_bytes);

/// Returns the points of a cloud with these channels, whatever their types are.
Result<Strides> point_strides_of(const DynamicView& cloud, std::span<const std::string_view> names);

}  // namespace sft
