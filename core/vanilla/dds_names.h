// The names in DDS of topics and types of ROS 2. Pure functions.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace sft::core {

/// Returns "rt/left/points" for "left/points".
std::string dds_topic(std::string_view topic);
/// Returns "sensor_msgs::msg::dds_::Imu_" for "sensor_msgs::msg::Imu".
std::string dds_type(std::string_view type);
/// Returns "left/points" for "rt/left/points", and nothing for names of another form.
std::optional<std::string> topic_of_dds(std::string_view topic);
/// Returns "sensor_msgs::msg::Imu" for "sensor_msgs::msg::dds_::Imu_". Names of another form are returned
/// as they are.
std::string type_of_dds(std::string_view type);
/// Returns "sensor_msgs/msg/Imu" for "sensor_msgs::msg::Imu".
std::string ros_type_name(std::string_view type);

}  // namespace sft::core
