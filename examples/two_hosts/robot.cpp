// robot [SECONDS]: publishes clouds of 6.3 MB, twenty per second. At the end it prints the number of bytes
// that were sent over the network.
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
  auto node = sft::Node::open({.name = "robot"});
  if (!node) return std::fprintf(stderr, "%s\n", node.error().message.c_str()), 1;
  auto points = node->publisher<PointCloud2>("robot/points");
  if (!points) return std::fprintf(stderr, "%s\n", points.error().message.c_str()), 1;

  std::puts("waiting for the station");
  if (!points->wait_for_subscribers(1, 60s)) return std::puts("no station came"), 1;
  PointCloud2 cloud{.height = 128, .width = 1024};
  cloud.data.resize(6'291'456);
  sft::PublisherStatus status;
  for (int i = 0; i < 20 * seconds; ++i) {
    points->publish(cloud);
    std::this_thread::sleep_for(50ms);
    status = points->status();
  }

  for (const sft::PublisherStatus::Reader& reader : status.readers) {
    std::printf("%s was sent %lu of %lu clouds by %s: %lu bytes, %lu saved\n", reader.node.c_str(),
                reader.sent, reader.published, to_string(reader.transport), reader.bytes_sent,
                reader.bytes_saved);
  }
}
