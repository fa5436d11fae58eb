// monitor [COUNT]: prints the size and the age of clouds. Ends after COUNT clouds, or if no more clouds
// arrive.
#include <sft/sft.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <sensor_msgs/msg/PointCloud2.hpp>

using namespace std::chrono_literals;
using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;

int main(int argc, char** argv) {
  int wanted = argc > 1 ? std::atoi(argv[1]) : 1'000'000;

  auto node = sft::Node::open({.name = "monitor"});
  if (!node) return std::fprintf(stderr, "%s\n", node.error().message.c_str()), 1;
  // Three fields are declared, and only these are sent. An access to any other field does not compile.
  auto points = node->subscriber<PointCloud2, F::header.stamp | F::height | F::width>("points");
  if (!points) return std::fprintf(stderr, "%s\n", points.error().message.c_str()), 1;

  while (wanted > 0 && points->wait(10s)) {
    while (const auto cloud = points->take()) {  // a sample is read in place, and is not copied
      const auto age = std::chrono::system_clock::now() - sft::to_time(cloud->header().stamp());
      std::printf("%u x %u points, %.2f ms old\n", cloud->height(), cloud->width(),
                  std::chrono::duration<double, std::milli>(age).count());
      --wanted;
    }
  }
}
