// This file says a second time, and in the plainest way, what a part of a message is (selection.md, "Parts"),
// to compare the runtime with: index by index, on the generated structs. What contradicts itself has to be
// said without doubt: where the specification leaves a choice, so do the tests that use this.
#pragma once

#include <cstddef>
#include <nav_msgs/msg/OccupancyGrid.hpp>
#include <optional>
#include <sensor_msgs/msg/Image.hpp>
#include <sensor_msgs/msg/LaserScan.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <string>
#include <vector>

#include "sft/selection.h"

namespace sft::test::cut_reference {

/// The indices below `count` that the range names, in ascending order.
std::vector<std::size_t> indices(const Selection::Range& range, std::size_t count);

/// Of a list without a layout.
template <class Element>
std::vector<Element> cut(const std::vector<Element>& list, const Selection::Range& range) {
  std::vector<Element> part;
  for (const std::size_t i : indices(range, list.size())) part.push_back(list[i]);
  return part;
}

/// Of `data`. The leaf of the part is not looked at, so that the message may be a member of another one.
sensor_msgs::msg::PointCloud2 cut(const sensor_msgs::msg::PointCloud2& cloud, const Selection::Part& part);
sensor_msgs::msg::Image cut(const sensor_msgs::msg::Image& image, const Selection::Part& part);
nav_msgs::msg::OccupancyGrid cut(const nav_msgs::msg::OccupancyGrid& grid, const Selection::Part& part);

/// Of `ranges` and `intensities`, as far as the selection has them.
sensor_msgs::msg::LaserScan cut(const sensor_msgs::msg::LaserScan& scan, const Selection& selection);
inline constexpr std::size_t ranges_leaf = 10;       ///< of LaserScan
inline constexpr std::size_t intensities_leaf = 11;  ///< of LaserScan

/// The channels that a part with these names has, as the cloud's `fields` describe them, by their offsets.
std::vector<sensor_msgs::msg::PointField> channels_of(const sensor_msgs::msg::PointCloud2& cloud,
                                                      const std::vector<std::string>& names);
/// The bytes of an element of one of the eight types of channels, and 0 of any other.
std::size_t bytes_of_datatype(std::uint8_t datatype);

/// The bytes of a pixel as the names of sensor_msgs/image_encodings say them; planes and unknown names have
/// none.
std::optional<std::size_t> bytes_of_encoding(const std::string& encoding);

}  // namespace sft::test::cut_reference
