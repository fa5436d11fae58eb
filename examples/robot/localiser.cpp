// Asks for x and y of every second point, and publishes a pose with the header of the cloud until it is
// interrupted.
#include <sft/sft.h>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <geometry_msgs/msg/PoseWithCovarianceStamped.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>

using namespace std::chrono_literals;
using geometry_msgs::msg::PoseWithCovarianceStamped;
using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;

std::atomic<sft::Node*> node_of_handler{nullptr};

int main() {
  sft::Node node = sft::Node::open({.name = "localiser"}).value();
  auto poses = node.publisher<PoseWithCovarianceStamped>("pose").value();
  auto points =
      node.subscriber<PointCloud2, F::header | F::data.channels<"x", "y">.every(2)>("points").value();
  node_of_handler = &node;
  for (const int signal : {SIGINT, SIGTERM})
    std::signal(signal, [](int) { node_of_handler.load()->interrupt(); });

  PoseWithCovarianceStamped pose;
  std::uint64_t clouds = 0, lost = 0;
  while (!node.is_interrupted()) {
    if (!points.wait(1s)) continue;
    while (const auto cloud = points.take_latest()) {
      const auto xy = cloud->points<float, float>("x", "y");
      if (!xy) {
        std::fprintf(stderr, "%s\n", xy.error().message.c_str());
        continue;
      }
      double sum_x = 0, sum_y = 0;
      for (const auto [x, y] : *xy) sum_x += x, sum_y += y;
      pose.header = cloud->header();
      pose.pose.pose.position.x = sum_x / double(xy->size());
      pose.pose.pose.position.y = sum_y / double(xy->size());
      poses.publish(pose);
      ++clouds;
      lost += cloud.info().lost_before;
    }
  }
  std::printf("%lu clouds, %lu lost, x %.1f\n", clouds, lost, pose.pose.pose.position.x);
}
