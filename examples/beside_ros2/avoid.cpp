// avoid: stops a robot before it meets an obstacle. The robot's driver is a node of DDS or ROS 2 that knows
// nothing of SFT. This program needs no setting for that.
#include <sft/sft.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <geometry_msgs/msg/Twist.hpp>
#include <sensor_msgs/msg/LaserScan.hpp>

using namespace std::chrono_literals;
using geometry_msgs::msg::Twist;
using sensor_msgs::msg::LaserScan;

int main() {
  auto node = sft::Node::open({.name = "avoid"});
  if (!node) return std::fprintf(stderr, "%s\n", node.error().message.c_str()), 1;
  auto commands = node->publisher<Twist>("cmd_vel");
  if (!commands) return std::fprintf(stderr, "%s\n", commands.error().message.c_str()), 1;
  auto scans = node->subscriber<LaserScan, LaserScan::Field::ranges>("scan");
  if (!scans) return std::fprintf(stderr, "%s\n", scans.error().message.c_str()), 1;

  bool has_stopped = false;
  auto timeout = 60s;  // the time to start the driver
  while (scans->wait(timeout)) {
    const auto scan = scans->take();
    if (!scan || scan->ranges().empty()) continue;
    const float nearest = std::ranges::min(scan->ranges());
    commands->publish({.linear = {.x = nearest < 1 ? 0 : 0.5}});
    if (timeout == 60s) std::printf("avoid: scans come by %s\n", to_string(scan.info().transport));
    if (nearest < 1 && !has_stopped) std::printf("avoid: an obstacle in %.2f m\n", nearest);
    has_stopped = nearest < 1;
    timeout = 2s;
  }
  return has_stopped ? 0 : 1;
}
