// Writes a cloud of up to 6 MB directly into the shared memory in which readers on this host read it.
#include <sft/sft.h>

#include <chrono>
#include <cstdio>
#include <cstring>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <thread>

using namespace std::chrono_literals;
using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;

struct Point {
  float x, y, z, intensity;
};
constexpr std::uint32_t points_max = 400'000;

int main() {
  auto node = sft::Node::open({.name = "loan_a_cloud"});
  if (!node) return std::fprintf(stderr, "%s\n", node.error().message.c_str()), 1;
  auto clouds = node->publisher<PointCloud2>("cloud").value();
  auto reader = node->subscriber<PointCloud2, F::width | F::data>("cloud").value();

  // The node may have to start the daemon of the shared memory. Clouds are sent by UDP until the daemon is
  // ready.
  int in_place = 0;
  for (std::uint32_t i = 0; i < 200 && in_place < 5; ++i) {
    // The number of points is not known yet, so the loan reserves memory for the largest cloud. This memory
    // is not set to zero.
    auto loan = clouds.loan_for_overwrite({.height = 1, .point_step = sizeof(Point)},
                                          {.data = points_max * std::uint32_t{sizeof(Point)}});
    if (!loan) return std::fprintf(stderr, "%s\n", loan.error().message.c_str()), 1;

    const std::uint32_t points = points_max - 1000 * i;
    const auto written = (*loan)->data();  // a span of bytes
    for (std::uint32_t p = 0; p < points; ++p) {
      const Point point{.x = 0.01F * static_cast<float>(p), .y = 0, .z = 0, .intensity = 1};
      std::memcpy(&written[p * sizeof point], &point, sizeof point);
    }
    loan->set(F::width, points);
    loan->shrink(F::data, points * std::uint32_t{sizeof(Point)});  // returns the unused memory
    const std::uint8_t* const written_at = written.data();
    std::move(*loan).publish();

    while (const auto cloud = reader.take()) {
      const bool same_memory = cloud->data().data() == written_at;
      std::printf("%u points, %zu bytes, read in the memory in which they were written: %s\n", cloud->width(),
                  cloud->data().size(), same_memory ? "yes" : "no");
      in_place += same_memory ? 1 : 0;
    }
    std::this_thread::sleep_for(100ms);
  }
  std::printf("shared memory: %s\n", node->status().shm.c_str());
}
