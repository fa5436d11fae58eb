// The names in DDS of topics and types: those of ROS 2, or plain ones. Pure functions. The examples are names
// of ROS 2.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "sft/options.h"

namespace sft::core {

using DdsNames = NodeOptions::DdsNames;

/// The topic of the graph of ROS 2 (ros_graph.h).
inline constexpr const char* ros_graph_topic = "ros_discovery_info";

/// Returns "rt/left/points" for "left/points".
std::string dds_topic(std::string_view topic, DdsNames names);
/// Returns "sensor_msgs::msg::dds_::Imu_" for "sensor_msgs::msg::Imu".
std::string dds_type(std::string_view type, DdsNames names);
/// Returns "left/points" for "rt/left/points", and nothing for names of another form or for the topic
/// of the graph of ROS 2.
std::optional<std::string> topic_of_dds(std::string_view topic, DdsNames names);
/// Returns "sensor_msgs::msg::Imu" for "sensor_msgs::msg::dds_::Imu_". Names of another form are returned
/// as they are.
std::string type_of_dds(std::string_view type, DdsNames names);
/// Returns "sensor_msgs/msg/Imu" for "sensor_msgs::msg::Imu".
std::string ros_type_name(std::string_view type);

}  // namespace sft::core
