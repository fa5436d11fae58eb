#include "tests/support/message_types.h"

#include <array>
#include <layouts.hpp>
#include <nav_msgs/msg/OccupancyGrid.hpp>
#include <nav_msgs/msg/Odometry.hpp>
#include <proof.hpp>
#include <sensor_msgs/msg/BatteryState.hpp>
#include <sensor_msgs/msg/Image.hpp>
#include <sensor_msgs/msg/LaserScan.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <torture.hpp>

namespace sft::test {

std::span<const MessageType> all_types() {
  static const std::array types{
      message_type<sensor_msgs::msg::PointCloud2>(),
      message_type<sensor_msgs::msg::LaserScan>(),
      message_type<sensor_msgs::msg::BatteryState>(),
      message_type<sensor_msgs::msg::Image>(),
      message_type<nav_msgs::msg::OccupancyGrid>(),
      message_type<nav_msgs::msg::Odometry>(),
      message_type<torture::Nested>(),
      message_type<torture::Arrays>(),
      message_type<torture::Sequences>(),
      message_type<torture::names::delete_>(),
      message_type<proof::Misaligned>(),
      message_type<proof::Scene>(),
      message_type<proof::Bounded>(),
      message_type<proof::Keyed>(),
      message_type<proof::MarkedElements>(),
      message_type<proof::Wide>(),
      message_type<proof::Chunks>(),
      message_type<layouts::HeightMap>(),
      message_type<layouts::Spectrum>(),
      message_type<layouts::Records>(),
      message_type<layouts::Points>(),
  };
  return types;
}

std::span<const MessageType> common_types() { return all_types().first(6); }

}  // namespace sft::test
