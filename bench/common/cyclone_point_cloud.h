// The point cloud of cloud.h as a message of Cyclone DDS.
#pragma once

#include <vector>

#include "bench/common/cloud.h"
#include "sensor_msgs/msg/PointCloud2.h"

namespace sft::bench {

class CyclonePointCloud {
 public:
  explicit CyclonePointCloud(std::size_t data_bytes);
  CyclonePointCloud(const CyclonePointCloud&) = delete;
  CyclonePointCloud& operator=(const CyclonePointCloud&) = delete;

  sensor_msgs_msg_PointCloud2& message() { return message_; }

 private:
  sensor_msgs::msg::PointCloud2 cloud_;  ///< owns what message_ points to
  std::vector<sensor_msgs_msg_PointField> fields_;
  sensor_msgs_msg_PointCloud2 message_{};
};

}  // namespace sft::bench
