#include "bench/selection/messages.h"

#include <cstddef>
#include <cstdint>

#include "bench/common/cloud.h"

namespace sft::bench {

sensor_msgs::msg::PointCloud2 ouster_cloud() {
  constexpr std::uint32_t point_bytes = 48;
  sensor_msgs::msg::PointCloud2 message = cloud(0);
  message.height = 128;
  message.width = 1024;
  message.fields = {{"x", 0, 7, 1},          {"y", 4, 7, 1},        {"z", 8, 7, 1},
                    {"intensity", 16, 7, 1}, {"t", 20, 6, 1},       {"reflectivity", 24, 4, 1},
                    {"ring", 26, 4, 1},      {"ambient", 28, 4, 1}, {"range", 32, 6, 1}};
  message.point_step = point_bytes;
  message.row_step = message.width * point_bytes;
  message.data.assign(std::size_t{message.height} * message.row_step, 1);
  return message;
}

}  // namespace sft::bench
