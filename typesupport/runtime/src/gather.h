// Copies the cells of a part to contiguous memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "sft/detail/cut.h"

namespace sft::detail {

/// Copies one run of each cell of a row. If the compiler knows the number of bytes, each copy takes one or
/// two instructions.
template <std::size_t Bytes>
void gather_run(std::byte* to, std::size_t to_stride, const std::byte* from, std::size_t from_stride,
                std::uint32_t cells) {
  for (std::uint32_t i = 0; i < cells; ++i, to += to_stride, from += from_stride)
    std::memcpy(to, from, Bytes);
}

inline void gather_run(std::size_t bytes, std::byte* to, std::size_t to_stride, const std::byte* from,
                       std::size_t from_stride, std::uint32_t cells) {
  switch (bytes) {
    case 1:
      return gather_run<1>(to, to_stride, from, from_stride, cells);
    case 2:
      return gather_run<2>(to, to_stride, from, from_stride, cells);
    case 3:
      return gather_run<3>(to, to_stride, from, from_stride, cells);
    case 4:
      return gather_run<4>(to, to_stride, from, from_stride, cells);
    case 8:
      return gather_run<8>(to, to_stride, from, from_stride, cells);
    case 12:
      return gather_run<12>(to, to_stride, from, from_stride, cells);
    case 16:
      return gather_run<16>(to, to_stride, from, from_stride, cells);
    default:
      for (std::uint32_t i = 0; i < cells; ++i, to += to_stride, from += from_stride)
        std::memcpy(to, from, bytes);
  }
}

/// Writes the cells of the part, cut.bytes() bytes, to `to`. The first cell begins at `from`.
inline void gather(const Cut& cut, std::byte* to, const std::byte* from) {
  for (std::uint32_t row = 0; row < cut.rows(); ++row) {
    std::byte* cell = to;
    for (const Cut::Run& run : cut.runs()) {
      gather_run(run.bytes, cell, cut.cell_bytes(), from + run.offset, cut.column_stride(), cut.columns());
      cell += run.bytes;
    }
    to += std::size_t{cut.columns()} * cut.cell_bytes();
    from += cut.row_stride();
  }
}

}  // namespace sft::detail
