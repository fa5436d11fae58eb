// The point cloud that benchmarks send, encode and decode.
#pragma once

#include <cstddef>
#include <cstdint>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <string>

namespace sft::bench {

std_msgs::msg::Header header(std::string frame_id);
sensor_msgs::msg::PointCloud2 cloud(std::size_t data_bytes);

}  // namespace sft::bench
