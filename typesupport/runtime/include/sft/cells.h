// The cells of a field in rows and columns, read in place: pixels, cells of a map, beams, and the
// elements of any sequence of numbers. The getter of such a field takes the type of a cell:
//
//   using Rgb = std::array<std::uint8_t, 3>;
//   if (const auto pixels = sample->data<Rgb>())
//     for (const auto [r, g, b] : *pixels) ...
//   if (const auto beams = sample->ranges<float>()) ...
//
//   sft::cells_of<Rgb>(sample.view(), "image.data")  // without the compiled type
//
// Nothing is copied, and a cell is read only when it is accessed. If the subscriber requested a part, the
// result has the cells of the part: in place in a whole image in shared memory, or in the smaller image that
// another host sent. (The getter without a type returns a span. For that it copies the bytes of a part
// together if they are not contiguous.)
//
// A loop that has to be fast goes row by row: `pixels->row(i)` is a span if the cells of the row are
// contiguous. A loop over all cells checks after each cell whether the row ends.
//
// The layout of a field defines its rows and columns (typesupport/runtime/selection.md, "Parts"). A field
// without rows counts as one row. A cell is one element of the field, unless the encoding of the image or
// the member for the size of a cell gives another size. The type of a cell is an arithmetic type or a
// std::array of such a type. If the elements of the field are numbers of several bytes, it must be the type
// of these numbers. The result is an error if
//   - a cell has another size, or the encoding has no such cells: type_mismatch
//   - the sample was sent without a field that gives the number of rows or columns or the size of a cell:
//     unavailable. If fields are recorded, the subscriber requests that field from then on. A mask that is
//     declared without one of these fields does not compile. A program that declares a part need not declare
//     these fields.
//   - the bytes of the sample are inconsistent or end early: malformed
// Values in big-endian fields of bytes are swapped. A field with fewer bytes than its cells need counts as
// empty.
//
// The points of clouds are read with points() (points.h). In templates, as in a
// callback that takes `const auto& sample`, C++ requires `sample->template data<Rgb>()`.
#pragma once

#include <array>
#include <bit>
#include <cassert>
#include <compare>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <optional>
#include <ranges>
#include <span>
#include <string_view>
#include <tuple>
#include <type_traits>

#include "sft/detail/cell_grid.h"
#include "sft/detail/element_type.h"
#include "sft/detail/layout_text.h"
#include "sft/result.h"
#include "sft/type_support.h"

namespace sft {

namespace detail {

/// The unsigned integer type with this number of bytes.
template <std::size_t Bytes>
using Bits = std::tuple_element_t<std::bit_width(Bytes) - 1,
                                  std::tuple<std::uint8_t, std::uint16_t, std::uint32_t, std::uint64_t>>;

inline std::uint16_t swapped_bits(std::uint16_t bits) { return __builtin_bswap16(bits); }
inline std::uint32_t swapped_bits(std::uint32_t bits) { return __builtin_bswap32(bits); }
inline std::uint64_t swapped_bits(std::uint64_t bits) { return __builtin_bswap64(bits); }

/// Reads one value, or several values one by one. Compilers keep values that are read one by one in
/// registers.
template <class T>
void read_value(const std::byte* at, T& value) {
  std::memcpy(&value, at, sizeof value);
}
template <class E, std::size_t N>
void read_value(const std::byte* at, std::array<E, N>& values) {
  for (std::size_t i = 0; i < N; ++i) read_value(at + i * sizeof(E), values[i]);
}

template <class T>
void swap_bytes(T& value) {
  if constexpr (sizeof(T) > 1) value = std::bit_cast<T>(swapped_bits(std::bit_cast<Bits<sizeof(T)>>(value)));
}
template <class E, std::size_t N>
void swap_bytes(std::array<E, N>& values) {
  for (E& value : values) swap_bytes(value);
}

/// True if T can be the type of a cell: an integer of 1 to 8 bytes, float or double, or a std::array of
/// these types.
template <class T>
inline constexpr bool is_cell = std::is_arithmetic_v<T> && !std::is_const_v<T> && !std::is_volatile_v<T> &&
                                !std::same_as<T, bool> && sizeof(T) <= 8;
template <class E, std::size_t N>
inline constexpr bool is_cell<std::array<E, N>> = N > 0 && is_cell<E>;

/// Reads a cell, which has one value or several.
template <class Cell>
struct CellReader {
  bool is_swapped = false;

  Cell operator()(const std::byte* at) const {
    Cell cell;
    read_value(at, cell);
    if (is_swapped) [[unlikely]]
      swap_bytes(cell);
    return cell;
  }
};

}  // namespace detail

/// The cells of a field: a range with random access, row by row, that works with std::ranges. The range is
/// a small value, and valid as long as the sample. Its iterators are valid as long as the sample, too, even
/// if the range is destroyed. Any number of threads may read a range. Its functions do not throw.
template <class Cell>
class Cells : public std::ranges::view_base {
 public:
  class iterator;
  /// The type of a cell.
  using value_type = Cell;

  /// Makes a range without cells.
  Cells() = default;
  /// For SFT's own code: makes the range. `reader` must not read beyond the bytes of a cell.
  Cells(const detail::CellGrid& grid, const detail::CellReader<Cell>& reader)
      : grid_(grid), reader_(reader) {}

  /// Returns the number of rows: 1 if the field has no rows, and 0 if the field contradicts itself.
  std::size_t rows() const { return grid_.rows; }
  /// Returns the number of cells in a row.
  std::size_t columns() const { return grid_.columns; }
  /// Returns the number of cells in all rows.
  std::size_t size() const { return grid_.size(); }
  /// Returns true if there are no cells.
  bool empty() const { return size() == 0; }

  /// Returns the cell in a row and a column, both counted from 0. REQUIRES: row < rows() and column <
  /// columns().
  Cell at(std::size_t row, std::size_t column) const {
    assert(row < rows() && column < columns());
    return reader_(grid_.at(row, column));
  }
  /// Returns a row as a span if its cells are in memory like an array of Cell. Returns nothing if the cells
  /// are a part with a step, have another byte order, or are at unaligned addresses. Points never have such
  /// rows. REQUIRES: row < rows().
  std::optional<std::span<const Cell>> row(std::size_t row) const requires detail::is_cell<Cell> {
    assert(row < rows());
    if (empty()) return std::span<const Cell>();
    const std::byte* const first = grid_.at(row, 0);
    const bool is_aligned = reinterpret_cast<std::uintptr_t>(first) % alignof(Cell) == 0;
    if (grid_.is_swapped || grid_.column_step != sizeof(Cell) || !is_aligned) return std::nullopt;
    return std::span<const Cell>(reinterpret_cast<const Cell*>(first), columns());
  }
  /// Returns the cell with this number, from 0, counted row by row. REQUIRES: i < size().
  Cell operator[](std::size_t i) const {
    assert(i < size());
    const std::size_t row = grid_.is_joined() ? 0 : i / grid_.columns;
    return reader_(grid_.at(row, i - row * grid_.columns));
  }
  /// Returns the first cell. REQUIRES: !empty().
  Cell front() const { return at(0, 0); }
  /// Returns the last cell. REQUIRES: !empty().
  Cell back() const { return at(rows() - 1, columns() - 1); }

  /// Returns an iterator to the first cell. Iterators go over the cells row by row.
  iterator begin() const { return {grid_.joined(), reader_, 0}; }
  /// Returns the iterator past the last cell.
  iterator end() const { return {grid_.joined(), reader_, size()}; }

 private:
  detail::CellGrid grid_{};
  detail::CellReader<Cell> reader_{};
};

/// A position among the cells.
template <class Cell>
class Cells<Cell>::iterator {
 public:
  using iterator_concept = std::random_access_iterator_tag;
  // The highest category that C++17 allows if elements are values.
  using iterator_category = std::input_iterator_tag;
  using value_type = Cell;
  using reference = value_type;
  using difference_type = std::ptrdiff_t;

  iterator() = default;

  value_type operator*() const { return reader_(grid_.first + offset_); }
  value_type operator[](difference_type n) const { return *(*this + n); }

  iterator& operator++() {
    offset_ += grid_.column_step;
    if (offset_ == row_end_) [[unlikely]] {
      offset_ += grid_.row_step - grid_.row_bytes();
      row_end_ += grid_.row_step;
    }
    return *this;
  }
  iterator operator++(int) {
    iterator before = *this;
    ++*this;
    return before;
  }
  iterator& operator--() {
    if (offset_ + grid_.row_bytes() == row_end_) {
      offset_ -= grid_.row_step - grid_.row_bytes();
      row_end_ -= grid_.row_step;
    }
    offset_ -= grid_.column_step;
    return *this;
  }
  iterator operator--(int) {
    iterator before = *this;
    --*this;
    return before;
  }

  iterator& operator+=(difference_type n) {
    move_to(static_cast<std::uint64_t>(position() + n));
    return *this;
  }
  iterator& operator-=(difference_type n) { return *this += -n; }
  friend iterator operator+(iterator i, difference_type n) { return i += n; }
  friend iterator operator+(difference_type n, iterator i) { return i += n; }
  friend iterator operator-(iterator i, difference_type n) { return i -= n; }
  friend difference_type operator-(const iterator& a, const iterator& b) {
    return a.position() - b.position();
  }
  friend bool operator==(const iterator& a, const iterator& b) { return a.offset_ == b.offset_; }
  friend auto operator<=>(const iterator& a, const iterator& b) { return a.offset_ <=> b.offset_; }

 private:
  friend Cells;
  iterator(const detail::CellGrid& grid, const detail::CellReader<Cell>& reader, std::uint64_t position)
      : grid_(grid), reader_(reader) {
    move_to(position);
  }

  void move_to(std::uint64_t position) {
    const std::uint64_t row = position / grid_.columns * grid_.row_step;
    offset_ = row + position % grid_.columns * grid_.column_step;
    row_end_ = row + grid_.row_bytes();
  }
  difference_type position() const {
    const std::uint64_t row = row_end_ - grid_.row_bytes();
    return static_cast<difference_type>(row / grid_.row_step * grid_.columns +
                                        (offset_ - row) / grid_.column_step);
  }

  // operator++ usually changes only one number, which then stays in a register.
  detail::CellGrid grid_ = detail::CellGrid{}.joined();
  detail::CellReader<Cell> reader_{};
  std::uint64_t offset_ = 0;                   ///< number of bytes from the first cell to the present one
  std::uint64_t row_end_ = grid_.row_bytes();  ///< number of bytes from the first cell to the end of its row
};

namespace detail {

template <class Cell>
Result<Cells<Cell>> cells_on(const Result<CellGrid>& grid) {
  static_assert(is_cell<Cell>,
                "a cell is a number of at most 8 bytes and not bool, or a std::array of these");
  if (!grid) return tl::unexpected(grid.error());
  return Cells<Cell>(*grid, {.is_swapped = grid->is_swapped});
}

/// Returns true if a field whose elements have this kind may have cells of type Cell. A field of bytes may
/// have cells of any type.
template <class Cell>
constexpr bool fits_elements(Kind kind) {
  return size_of(kind) == 1 || holds<Cell>(kind);
}

/// Returns the cells of member number M. The getters of generated views call this function with the place
/// of the view (view.h).
template <class Cell, std::size_t M, class Place>
Result<Cells<Cell>> cells_at(const Place& place) {
  constexpr const Member& m = TypeTable<typename Place::Struct>::members[M];
  static_assert(fits_elements<Cell>(m.kind),
                "the field has cells of another type, which is that of its elements");
  constexpr std::size_t leaf = Place::template leaf_of<M>;
  if constexpr (Place::is_indexed) {
    constexpr const StructType& type = TypeTable<typename Place::Struct>::type;
    constexpr std::string_view rule = rule_of(type, m);
    static_assert(path_of_role(rule, "channels").empty(),
                  "the cells of this field have channels: read the points, sample->points<float>(\"x\")");
    static_assert(!Place::declares_mask || !path_of_role(rule, "channels").empty() ||
                      has_fields_of_cells(Place::declared, type, Place::first_leaf, rule),
                  "the declared mask lacks a field that the cells need: add the numbers of rows and columns, "
                  "the bytes of a row or cell, the byte order and the encoding (of an Image: height, width, "
                  "step, is_bigendian, encoding), or declare a part, F::data.rows(0, 10)");
  }
  CellsPlace cells{.sample = &place.state(),
                   .member = &m,
                   .leaf = leaf,
                   .offset = place.state().mask->contains(leaf) ? place.template begin_of<M>() : no_offset};
  if constexpr (Place::is_indexed) cells.layout = type_support<typename Place::Root>().layout_of(leaf);
  if constexpr (Place::declares_mask) {
    static const FieldMask declared(Place::declared);
    cells.declared = &declared;
  }
  return cells_on<Cell>(find_cells(cells, sizeof(Cell)));
}

}  // namespace detail

/// Returns the cells of the field with this path in a message that is read by the names of its fields
/// (dynamic_view.h). The cells are valid as long as the sample. Further errors: unknown_field if there is
/// no such field, and type_mismatch if the field is not a sequence of numbers.
template <class Cell>
Result<Cells<Cell>> cells_of(const DynamicView& message, std::string_view path) {
  return detail::cells_on<Cell>(detail::find_cells(message, path, sizeof(Cell), detail::fits_elements<Cell>));
}

}  // namespace sft

/// @cond not in the reference: Doxygen does not accept specializations of unknown templates
template <class Cell>
inline constexpr bool std::ranges::enable_borrowed_range<sft::Cells<Cell>> = true;
/// @endcond
