// A message type as the text of .msg files.
#pragma once

#include <string>

#include "sft/detail/type_table.h"

namespace sft::tool {

/// Returns the message, followed by each nested message once, separated as rosbag and `ros2 interface show`
/// do:
///
///   std_msgs/Header header
///   ================================================================================
///   MSG: std_msgs/Header
///   ...
///
/// Units, enumerations and keys are comments. Defaults and constants are missing, since types are announced
/// without them.
std::string msg_text(const StructType& type);

/// Returns the name in .msg files: "sensor_msgs/PointCloud2" for "sensor_msgs::msg::PointCloud2".
std::string msg_name(std::string_view name);
/// Returns the name in ROS 2's tools: "sensor_msgs/msg/PointCloud2" for "sensor_msgs::msg::PointCloud2".
std::string ros_name(std::string_view name);

}  // namespace sft::tool
