// A message with a header, numbers, structs with strings, and bytes.
#pragma once

#include <cstddef>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <string>

namespace sft::test {

inline sensor_msgs::msg::PointCloud2 small_cloud(const std::string& frame = "lidar",
                                                 std::size_t bytes = 200) {
  sensor_msgs::msg::PointCloud2 c;
  c.header.stamp.sec = 7;
  c.header.frame_id = frame;
  c.height = 1;
  c.width = 1024;
  c.fields.resize(2);
  c.fields[0].name = "x";
  c.fields[1].name = "y";
  c.data.resize(bytes, 9);
  return c;
}

}  // namespace sft::test
