// Random messages with layouts. They do not contradict themselves and have something in each row, but have
// all that is allowed beside that: padding, bytes behind the data, channels that overlap, recur or reach
// beyond the point.
#pragma once

#include <cstdint>
#include <nav_msgs/msg/OccupancyGrid.hpp>
#include <sensor_msgs/msg/Image.hpp>
#include <sensor_msgs/msg/LaserScan.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <string>
#include <vector>

#include "sft/selection.h"
#include "tests/support/test_seed.h"

namespace sft::test {

class RandomLayouts {
 public:
  explicit RandomLayouts(Random& random) : random_(random) {}

  std::uint32_t below(std::uint64_t end) { return static_cast<std::uint32_t>(random_() % end); }
  bool one_in(std::uint64_t n) { return random_() % n == 0; }
  double between(double least, double most) {
    return std::uniform_real_distribution<double>(least, most)(random_);
  }

  /// Often all, and sometimes empty or beyond the edge. The step is one of 1 to 5.
  Selection::Range range(std::uint32_t count);
  /// The same, but without all that may be empty.
  Selection::Range range_with_some(std::uint32_t count);

  sensor_msgs::msg::PointCloud2 cloud();
  /// Some of those that cloud() may have, and others.
  std::vector<std::string> channels();
  /// Of any encoding.
  sensor_msgs::msg::Image image();
  sensor_msgs::msg::Image image(const std::string& encoding);
  nav_msgs::msg::OccupancyGrid grid();
  sensor_msgs::msg::LaserScan scan();

 private:
  std_msgs::msg::Header header();
  std::uint32_t rows_or_columns() { return one_in(20) ? 100 + below(300) : 1 + below(16); }
  template <class Byte>
  std::vector<Byte> bytes(std::size_t count);
  void add_odd_channels(sensor_msgs::msg::PointCloud2& cloud);

  Random& random_;
};

}  // namespace sft::test
