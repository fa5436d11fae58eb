// A lidar, which writes its clouds in the memory where readers read them.
#include <sft/sft.h>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <thread>
#include <utility>

using namespace std::chrono_literals;
using sensor_msgs::msg::PointCloud2;

int main(int argc, char** argv) {
  const int count = argc > 1 ? std::atoi(argv[1]) : 600;
  sft::Node node = sft::Node::open({.name = "lidar"}).value();
  sft::Publisher<PointCloud2> points = node.publisher<PointCloud2>("points").value();

  constexpr std::uint32_t rows = 128, columns = 1024, step = 16;
  PointCloud2 layout{.height = rows,
                     .width = columns,
                     .fields = {{"x", 0, 7, 1}, {"y", 4, 7, 1}, {"z", 8, 7, 1}, {"intensity", 12, 7, 1}},
                     .point_step = step,
                     .row_step = columns * step,
                     .is_dense = true};
  layout.header.frame_id = "lidar";
  for (int i = 0; i < count; ++i) {
    layout.header.stamp = sft::time_message<builtin_interfaces::msg::Time>(node.now());
    auto cloud = points.loan_for_overwrite(layout, {.data = rows * columns * step});
    if (!cloud) return std::fprintf(stderr, "%s\n", cloud.error().message.c_str()), 1;
    const auto data = (*cloud)->data();
    for (std::uint32_t p = 0; p < rows * columns; ++p) {
      const float xyzi[4] = {float(p % columns), float(p / columns), 1.5F, float(i)};
      std::memcpy(data.data() + p * step, xyzi, sizeof xyzi);
    }
    if (std::move(*cloud).publish() == sft::PublishStatus::invalid)
      std::fprintf(stderr, "%s\n", points.why_invalid().c_str());
    std::this_thread::sleep_for(100ms);
  }
}
