// The messages from which parts are taken.
#pragma once

#include <sensor_msgs/msg/PointCloud2.hpp>

namespace sft::bench {

/// Returns an organised cloud with the channels of an Ouster OS1-128. It has 6.29 MB, of which x, y and z
/// are a quarter.
sensor_msgs::msg::PointCloud2 ouster_cloud();

}  // namespace sft::bench
