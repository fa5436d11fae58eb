// What the encoding of an image says about its pixels. The names are those of sensor_msgs/image_encodings.
#pragma once

#include <cstdint>
#include <string_view>

#include "sft/selection.h"

namespace sft::detail {

class Pixels {
 public:
  struct Image {
    std::uint64_t rows, columns, row_bytes, data_bytes;
  };

  static Pixels of(std::string_view encoding);

  /// Bytes of a pixel; 0: they cannot be told.
  std::uint64_t bytes_in(const Image& image) const;
  /// Whether these pixels of rows with so many are an image of the same encoding, or of one that
  /// pattern_at() names.
  bool have(const Selection::Range& rows, const Selection::Range& columns, std::uint64_t count) const;
  /// The Bayer pattern that begins at this row and column; null: there is no pattern.
  const char* pattern_at(std::uint32_t row, std::uint32_t column) const;

 private:
  enum class Order : std::uint8_t { unknown, single, pairs, planes, bayer };
  Order order_ = Order::unknown;
  std::uint8_t pattern_ = 0;  ///< bit 0: begins at an odd column of rggb; bit 1: at an odd row
  std::uint32_t bytes_ = 0;
};

}  // namespace sft::detail
