// The point cloud that benchmarks send, encode and decode.
#pragma once

#include <cstddef>
#include <cstdint>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <string>

namespace sft::bench {

inline constexpr std::uint32_t sent_cloud_bytes = 6'291'456;  ///< data of 393,216 points of 16 bytes

std_msgs::msg::Header header(std::string frame_id);
sensor_msgs::msg::PointCloud2 cloud(std::size_t data_bytes);

}  // namespace sft::bench
