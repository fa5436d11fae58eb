// Formats a message type as the text of .msg files.
#pragma once

#include <functional>
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
/// Units, enumerations and keys are comments. Defaults are missing, since types are announced without them,
/// and so are constants, except for the lines that `constants_of` has for a message.
using ConstantsOf = std::function<std::string(const StructType&)>;
std::string msg_text(const StructType& type, const ConstantsOf& constants_of);

/// Returns the name as in .msg files: "sensor_msgs/PointCloud2" for "sensor_msgs::msg::PointCloud2".
std::string msg_name(std::string_view name);
/// Returns the name as in the tools of ROS 2: "sensor_msgs/msg/PointCloud2" for
/// "sensor_msgs::msg::PointCloud2".
std::string ros_name(std::string_view name);

}  // namespace sft::tool
