// Random messages with layouts. The messages do not contradict themselves, and no row is empty. Otherwise
// they have all properties that are allowed: padding, bytes after the data, and channels that overlap,
// recur or reach beyond the end of the point.
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

  /// Returns a range with a step from 1 to 5. The range often covers all indices, and sometimes is empty or
  /// reaches beyond the end.
  Selection::Range range(std::uint32_t count);
  /// Returns a range as range() does, but never an empty one.
  Selection::Range range_with_some(std::uint32_t count);

  sensor_msgs::msg::PointCloud2 cloud();
  /// Returns names of channels: some that cloud() may have, and some that it never has.
  std::vector<std::string> channels();
  /// Returns an image of a random encoding.
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
