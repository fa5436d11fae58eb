// Files of the Point Cloud Library, version 0.7 (.pcd): a header of text lines, then the points as text or as
// they lie in memory. Compressed ones are refused, with the command that converts them.
#pragma once

#include <string>
#include <string_view>

#include "tools/demo/clouds/input_cloud.h"

namespace sft::demo {

struct PcdField {
  std::string name;
  std::uint32_t size = 0;  ///< bytes of one number
  char type = '?';         ///< F float, I signed, U unsigned
  std::uint32_t count = 1;
};

struct PcdHeader {
  enum class Storage { ascii, binary };

  std::vector<PcdField> fields;
  std::uint32_t width = 0;
  std::uint32_t height = 1;
  Storage storage = Storage::ascii;
  std::size_t bytes = 0;  ///< of the header: the points begin here

  std::uint32_t point_bytes() const;
  std::uint64_t points() const { return std::uint64_t{width} * height; }
};

/// Everything in it is checked but whether the points are there.
Result<PcdHeader> read_pcd_header(std::string_view file);

Result<std::vector<InputCloud>> read_pcd(std::span<const std::byte> file, std::size_t limit);

}  // namespace sft::demo
