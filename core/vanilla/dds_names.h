// The names that topics and types of ROS 2 have in DDS. Pure.
#pragma once

#include <string>
#include <string_view>

namespace sft::core {

/// "rt/left/points" of "left/points".
std::string dds_topic(std::string_view topic);
/// "sensor_msgs::msg::dds_::Imu_" of "sensor_msgs::msg::Imu".
std::string dds_type(std::string_view type);
/// "sensor_msgs/msg/Imu" of "sensor_msgs::msg::Imu".
std::string ros_type_name(std::string_view type);

}  // namespace sft::core
