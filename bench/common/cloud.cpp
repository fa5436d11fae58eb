#include "bench/common/cloud.h"

#include <utility>

namespace sft::bench {

std_msgs::msg::Header header(std::string frame_id) {
  return {.stamp = {.sec = 1'700'000'000, .nanosec = 123'456'789}, .frame_id = std::move(frame_id)};
}

sensor_msgs::msg::PointCloud2 cloud(std::size_t data_bytes) {
  sensor_msgs::msg::PointCloud2 cloud{.header = header("lidar_front"),
                                      .height = 1,
                                      .width = static_cast<std::uint32_t>(data_bytes / 16),
                                      .point_step = 16,
                                      .row_step = static_cast<std::uint32_t>(data_bytes),
                                      .is_dense = true};
  for (const char* name : {"x", "y", "z", "intensity"}) {
    const auto offset = static_cast<std::uint32_t>(4 * cloud.fields.size());
    cloud.fields.push_back({.name = name, .offset = offset, .datatype = 7, .count = 1});
  }
  cloud.data.resize(data_bytes);
  for (std::size_t i = 0; i < data_bytes; ++i) cloud.data[i] = static_cast<std::uint8_t>(i * 31 % 251);
  return cloud;
}

}  // namespace sft::bench
