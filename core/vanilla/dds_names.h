// The names that topics and types of ROS 2 have in DDS. Pure.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace sft::core {

/// "rt/left/points" of "left/points".
std::string dds_topic(std::string_view topic);
/// "sensor_msgs::msg::dds_::Imu_" of "sensor_msgs::msg::Imu".
std::string dds_type(std::string_view type);
/// "left/points" of "rt/left/points"; nothing for names of another form.
std::optional<std::string> topic_of_dds(std::string_view topic);
/// "sensor_msgs::msg::Imu" of "sensor_msgs::msg::dds_::Imu_". Names of another form are returned as they are.
std::string type_of_dds(std::string_view type);
/// "sensor_msgs/msg/Imu" of "sensor_msgs::msg::Imu".
std::string ros_type_name(std::string_view type);

}  // namespace sft::core
