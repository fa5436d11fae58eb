// A message type as the text of .msg files.
#pragma once

#include <string>

#include "sft/typesupport/type_table.h"

namespace sft::tool {

/// The message, and behind it all that it nests, each once, as rosbag and `ros2 interface show` separate
/// them:
///
///   std_msgs/Header header
///   ================================================================================
///   MSG: std_msgs/Header
///   ...
///
/// Units, enumerations and keys are comments. Defaults and constants do not travel with a type, and are not
/// there.
std::string msg_text(const StructType& type);

/// "sensor_msgs/PointCloud2" of "sensor_msgs::msg::PointCloud2": what .msg files call it.
std::string msg_name(std::string_view name);
/// "sensor_msgs/msg/PointCloud2" of "sensor_msgs::msg::PointCloud2": what ROS 2's tools call it.
std::string ros_name(std::string_view name);

}  // namespace sft::tool
