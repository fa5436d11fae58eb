// The names that topics and types have in DDS: those of ROS 2, or the names themselves. Pure.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "sft/options.h"

namespace sft::core {

using DdsNames = NodeOptions::DdsNames;

/// "rt/left/points" of "left/points".
std::string dds_topic(std::string_view topic, DdsNames names = DdsNames::ros2);
/// "sensor_msgs::msg::dds_::Imu_" of "sensor_msgs::msg::Imu".
std::string dds_type(std::string_view type, DdsNames names = DdsNames::ros2);
/// "left/points" of "rt/left/points"; nothing for names of another form.
std::optional<std::string> topic_of_dds(std::string_view topic, DdsNames names = DdsNames::ros2);
/// "sensor_msgs::msg::Imu" of "sensor_msgs::msg::dds_::Imu_". Names of another form are returned as they are.
std::string type_of_dds(std::string_view type, DdsNames names = DdsNames::ros2);
/// "sensor_msgs/msg/Imu" of "sensor_msgs::msg::Imu".
std::string ros_type_name(std::string_view type);

}  // namespace sft::core
