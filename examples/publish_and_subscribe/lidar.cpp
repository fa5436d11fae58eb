// lidar [SECONDS]: publishes clouds of 6.3 MB on the topic "points", ten per second.
#include <sft/sft.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <thread>

using namespace std::chrono_literals;
using sensor_msgs::msg::PointCloud2;

int main(int argc, char** argv) {
  const int seconds = argc > 1 ? std::atoi(argv[1]) : 60;

  auto node = sft::Node::open({.name = "lidar"});
  if (!node) return std::fprintf(stderr, "%s\n", node.error().message.c_str()), 1;
  auto points = node->publisher<PointCloud2>("points");
  if (!points) return std::fprintf(stderr, "%s\n", points.error().message.c_str()), 1;

  PointCloud2 cloud{.height = 128, .width = 1024, .point_step = 48, .row_step = 48 * 1024};
  cloud.header.frame_id = "lidar";
  cloud.data.resize(cloud.height * cloud.row_step);
  for (int i = 0; i < 10 * seconds; ++i) {
    cloud.header.stamp = sft::time_message<builtin_interfaces::msg::Time>(std::chrono::system_clock::now());
    points->publish(cloud);  // costs almost no time without subscribers
    std::this_thread::sleep_for(100ms);
  }
}
