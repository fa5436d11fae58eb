// Parts of fields whose declarations the compiler evaluates (sft/detail/declared_part.h).
#include <sft/sft.h>

#include <sensor_msgs/msg/Image.hpp>
#include <sensor_msgs/msg/LaserScan.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>

using sensor_msgs::msg::Image;
using sensor_msgs::msg::LaserScan;
using sensor_msgs::msg::PointCloud2;

int main() {
  sft::Node node = sft::Node::open().value();
  using Cloud = PointCloud2::Field;
  using Scan = LaserScan::Field;
  const auto points = node.subscriber<PointCloud2, Cloud::header.stamp | Cloud::data.channels<"x", "y", "z">>(
      "points", [](const auto& cloud) { static_cast<void>(cloud->template points<float, float>("x", "y")); });
  const auto beams = node.subscriber<LaserScan, Scan::angle_min | Scan::ranges.every(4)>("scan");
  const auto window = node.subscriber<Image, Image::Field::data.rows(10, 20).columns(0, 640, 2)>("image");
  return points && beams && window ? 0 : 1;
}
