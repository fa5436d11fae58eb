// Clouds as they were found in files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "tools/demo/clouds/cloud_source.h"

namespace sft::demo {

/// What one sample may have at most, which is what publishers announce by default.
inline constexpr std::size_t cloud_bytes_max = 16 * 1024 * 1024;

/// A message as DDS would send it. Published as it is.
struct EncodedCloud {
  std::vector<std::byte> payload;  ///< encapsulation and body, nothing behind
};

/// A message made from points of another format. They are kept apart: they go from here right into the memory
/// of a loan.
struct ConvertedCloud {
  PointCloud2 prototype;  ///< all but the data
  std::vector<std::uint8_t> data;
};

using InputCloud = std::variant<EncodedCloud, ConvertedCloud>;

std::string shape_of(const InputCloud& cloud);

/// Takes a payload if it is a little-endian PointCloud2 whose figures fit together; else says what it is not.
/// Padding at its end is cut off.
Result<EncodedCloud> check_payload(std::span<const std::byte> payload);

/// A cloud of `height` rows of `width` points, with the given fields. REQUIRES: the data is as long as that
/// takes.
Result<ConvertedCloud> convert(std::uint32_t height, std::uint32_t width, std::uint32_t point_step,
                               std::vector<sensor_msgs::msg::PointField> fields,
                               std::span<const std::byte> data);

}  // namespace sft::demo
