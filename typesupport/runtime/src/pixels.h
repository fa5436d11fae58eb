// Determines the properties of pixels that follow from the encoding of an image. The names of encodings are
// those of sensor_msgs/image_encodings.
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

  /// Returns the size of a pixel in bytes; 0 if the size cannot be determined.
  std::uint64_t bytes_in(const Image& image) const;
  /// Returns true if the selected pixels, of rows with `count` pixels, are an image of the same encoding,
  /// or of the encoding that pattern_at() returns.
  bool have(const Selection::Range& rows, const Selection::Range& columns, std::uint64_t count) const;
  /// Returns the Bayer pattern of a part that begins at this row and column; null if there is no pattern.
  const char* pattern_at(std::uint32_t row, std::uint32_t column) const;

 private:
  enum class Order : std::uint8_t { unknown, single, pairs, planes, bayer };
  Order order_ = Order::unknown;
  std::uint8_t pattern_ = 0;  ///< bit 0: the image begins at an odd column of rggb; bit 1: at an odd row
  std::uint32_t bytes_ = 0;
};

}  // namespace sft::detail
