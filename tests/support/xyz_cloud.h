// Clouds for tests in which subscribers request some channels of some points.
#pragma once

#include <cstddef>
#include <cstdint>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <vector>

namespace sft::test {

inline constexpr std::uint32_t points = 4000, point_bytes = 16;

/// Returns a cloud with x, y, z and intensity of each point. Its stamp is `number`.
inline sensor_msgs::msg::PointCloud2 xyz_cloud(std::uint32_t number) {
  sensor_msgs::msg::PointCloud2 cloud;
  cloud.header.stamp.sec = static_cast<std::int32_t>(number);
  cloud.height = 1;
  cloud.width = points;
  cloud.fields = {{"x", 0, 7, 1}, {"y", 4, 7, 1}, {"z", 8, 7, 1}, {"intensity", 12, 7, 1}};
  cloud.point_step = point_bytes;
  cloud.row_step = point_bytes * points;
  cloud.data.resize(std::size_t{point_bytes} * points);
  for (std::size_t i = 0; i < cloud.data.size(); ++i)
    cloud.data[i] = static_cast<std::uint8_t>(i * 7 + number);
  return cloud;
}

/// Returns the bytes of x, y and z of every fourth point.
inline std::vector<std::uint8_t> thinned(const sensor_msgs::msg::PointCloud2& cloud) {
  std::vector<std::uint8_t> bytes;
  for (std::size_t point = 0; point < points; point += 4) {
    const auto first = cloud.data.begin() + static_cast<std::ptrdiff_t>(point * point_bytes);
    bytes.insert(bytes.end(), first, first + 12);
  }
  return bytes;
}

}  // namespace sft::test
