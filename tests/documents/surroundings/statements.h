// Surrounds statements in a block of a document. The statements are in a function of a program that has a
// node.
#include <sft/sft.h>

#include <cstdio>
#include <nav_msgs/msg/OccupancyGrid.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <string>

void statements(sft::Node node);

void statements([[maybe_unused]] sft::Node node) {
  using namespace std::chrono_literals;
  using nav_msgs::msg::OccupancyGrid;
  using sensor_msgs::msg::PointCloud2;
  using F [[maybe_unused]] = PointCloud2::Field;
#include BLOCK
}
