// station [udp]: watches the clouds of a robot on another machine. With "udp" the robot may be on the same
// machine, too.
#include <sft/sft.h>

#include <chrono>
#include <cstdio>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <string_view>

using namespace std::chrono_literals;
using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;

int main(int argc, char** argv) {
  sft::NodeOptions options{.name = "station"};
  // By default, nodes on one machine use shared memory, and nodes on different machines use UDP.
  if (argc > 1 && std::string_view(argv[1]) == "udp") options.transport = sft::TransportChoice::udp;
  auto node = sft::Node::open(options);
  if (!node) return std::fprintf(stderr, "%s\n", node.error().message.c_str()), 1;

  // Requests only two numbers of a cloud, at most five times per second. The robot sends nothing else.
  auto points = node->subscriber<PointCloud2, F::height | F::width>("robot/points", {.max_rate_hz = 5});
  if (!points) return std::fprintf(stderr, "%s\n", points.error().message.c_str()), 1;
  auto timeout = 60s;  // the time to start the robot
  while (points->wait(timeout)) {
    while (const auto cloud = points->take())
      std::printf("%u x %u points\n", cloud->height(), cloud->width());
    timeout = 2s;
  }
  std::printf("%lu clouds came, %lu were lost\n", points->status().received, points->status().lost);
}
