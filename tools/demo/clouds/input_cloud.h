// Clouds from files, in the form in which they are published.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "tools/demo/clouds/cloud_source.h"

namespace sft::demo {

/// The largest sample that publishers announce by default.
inline constexpr std::size_t cloud_bytes_max = 16 * 1024 * 1024;

struct InputCloud {
  std::vector<std::byte> payload;  ///< encapsulation and body as DDS would send them, and no more bytes
  std::string shape;               ///< see CloudSource::shape()
};

/// Returns a source that publishes the clouds one after the other, again and again. REQUIRES: there is at
/// least one cloud.
std::unique_ptr<CloudSource> file_source(std::string name, std::vector<InputCloud> clouds);

/// Returns the cloud of a payload if that is a little-endian PointCloud2 whose sizes agree. The error says
/// what it is instead. Padding at the end of the payload is cut off.
Result<InputCloud> check_payload(std::span<const std::byte> payload);

/// Encodes one cloud of `height` rows of `width` points. REQUIRES: the data has height * width * point_step
/// bytes.
Result<std::vector<InputCloud>> convert(std::uint32_t height, std::uint32_t width, std::uint32_t point_step,
                                        std::vector<sensor_msgs::msg::PointField> fields,
                                        std::span<const std::byte> data);

}  // namespace sft::demo
