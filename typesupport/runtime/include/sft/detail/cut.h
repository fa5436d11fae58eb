// A part of one field of one sample: the places of its bytes, and the new values of the fields that depend
// on the part (selection.md, "Parts"). The header of a sample may be hostile, and in shared memory it may
// change while it is read. So each number of the header is read once, checked, and stored here.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "sft/detail/layout.h"
#include "sft/detail/walk.h"
#include "sft/selection.h"

namespace sft::detail {

class Cut {
 public:
  /// Bytes of a cell that are contiguous, both in the sample and in the part.
  struct Run {
    std::uint32_t offset;
    std::uint32_t bytes;
  };
  struct Channel {
    Extent name;  ///< the name of the encoding, with its NUL
    std::uint32_t offset;
    std::uint32_t bytes;
    std::uint32_t count;
    std::uint8_t type;
  };

  /// Finds a part of the field `data`. Finds nothing in a field of strings. If the field is a list and has
  /// no layout, `layout` is null. The sample must have all fields of the layout. Returns false if the bytes
  /// of the sample are malformed.
  bool find(const SampleState& s, const Layout* layout, const Layout::Field& data,
            const Selection::Part& part);

  /// Finds all cells of a field with rows, but not the values of the fields that depend on the part.
  bool find_all(const SampleState& s, const Layout& layout, const Layout::Field& data);

  /// Returns true if the part is the whole field. In that case, the field and all fields that depend on the
  /// part do not change.
  bool is_whole() const { return is_whole_; }

  std::uint64_t bytes() const { return std::uint64_t{rows_} * columns_ * cell_bytes_; }
  /// Returns the number of bytes of the field that the part leaves out.
  std::uint64_t bytes_less() const { return is_whole_ ? 0 : field_bytes_ - bytes(); }
  /// Returns the length of the part as the sequence `data`: the number of elements of a list, otherwise the
  /// number of bytes.
  std::uint32_t elements() const;
  /// Return the position of the first cell in the sample's body, the distance to the next cell of the row,
  /// and the distance to the same cell of the next row, all in bytes.
  std::uint64_t begin() const { return begin_; }
  std::uint64_t column_stride() const { return column_stride_; }
  std::uint64_t row_stride() const { return row_stride_; }
  std::uint32_t rows() const { return rows_; }
  std::uint32_t columns() const { return columns_; }
  std::uint32_t cell_bytes() const { return cell_bytes_; }
  std::span<const Run> runs() const { return {runs_.data(), run_count_}; }

  // Return the new values of the fields that have a role in the layout.
  std::uint32_t natural(LayoutRole role) const;  ///< the roles rows, columns, cell_bytes and row_bytes
  double real(LayoutRole role) const { return reals_[static_cast<std::size_t>(role)]; }
  const std::array<double, 3>& position() const { return position_; }
  std::span<const Channel> channels() const { return {channels_.data(), channel_count_}; }
  /// Returns four letters that replace four letters of the encoding's name; null: the name does not change.
  const char* pattern() const { return pattern_; }

  /// The position of the letters of pattern() in the name.
  static constexpr std::size_t pattern_at = 6;
  static constexpr std::size_t pattern_letters = 4;

 private:
  using Part = Selection::Part;
  struct Size {
    std::uint64_t rows, columns, cell_bytes, row_bytes;
  };

  void clear();
  bool find_list(const SampleState& s, const Layout* layout, const Layout::Field& data, const Part& part);
  bool find_beams(const SampleState& s, const Layout& layout, const Part& part);
  bool find_rows(const SampleState& s, const Layout& layout, const Layout::Field& data, const Part& part);
  bool place_rows(const SampleState& s, const Layout& layout, const Layout::Field& data, const Part& part);
  bool find_cells(const SampleState& s, const Layout& layout, std::uint64_t data_bytes, const Part& part,
                  Size& size);
  bool find_grid(const SampleState& s, const Layout& layout, const Part& part);
  bool find_channels(const SampleState& s, const Layout& layout, const Part& part, std::uint64_t cell_bytes);
  void pack_channels();
  void place(const Size& size, std::uint64_t first, const Part& part);

  bool is_whole_ = false;
  std::uint64_t field_bytes_ = 0;
  std::uint64_t begin_ = 0;
  std::uint64_t row_stride_ = 0;
  std::uint64_t column_stride_ = 0;
  std::uint32_t rows_ = 0;
  std::uint32_t columns_ = 0;
  std::uint32_t cell_bytes_ = 0;
  std::uint32_t element_bytes_ = 1;
  const char* pattern_ = nullptr;
  std::array<double, layout_roles> reals_{};
  std::array<double, 3> position_{};
  std::size_t run_count_ = 0;
  std::size_t channel_count_ = 0;
  std::array<Run, Selection::channels_max> runs_{};
  /// Channels of the part in ascending order of offsets.
  std::array<Channel, Selection::channels_max> channels_{};
};

}  // namespace sft::detail
