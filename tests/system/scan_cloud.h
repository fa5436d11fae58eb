// A cloud of several rows. Its bytes depend on its number.
#pragma once

#include <cstdint>

#include "tests/system/fixture.h"

namespace sft::test {

/// Returns a cloud with four rows of 50 points. There are gaps between the channels x, y and ring, and
/// after each row.
inline PointCloud2 scan_cloud(std::uint64_t number) {
  using sensor_msgs::msg::PointField;
  PointCloud2 cloud;
  cloud.header.stamp.sec = static_cast<std::int32_t>(number);
  cloud.header.frame_id = "lidar";
  cloud.height = 4;
  cloud.width = 50;
  cloud.point_step = 14;
  cloud.row_step = 50 * 14 + 3;
  const auto channel = [&](const char* name, std::uint32_t offset, std::uint8_t datatype) {
    cloud.fields.push_back({.name = name, .offset = offset, .datatype = datatype, .count = 1});
  };
  channel("x", 0, PointField::FLOAT32);
  channel("y", 5, PointField::FLOAT32);
  channel("ring", 10, PointField::UINT16);
  cloud.data.resize(std::size_t{4} * cloud.row_step);
  for (std::size_t i = 0; i < cloud.data.size(); ++i)
    cloud.data[i] = static_cast<std::uint8_t>(i * 7 + number * 31);
  return cloud;
}

}  // namespace sft::test
