// A second, simple implementation of parts of messages (selection.md, "Parts"), with which the runtime is
// compared. It works index by index on the generated structs. If a message contradicts itself, the
// specification sometimes leaves a choice. This implementation does not handle such messages, and the tests
// that use it avoid them.
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

/// Returns the indices less than `count` that the range names, in ascending order.
std::vector<std::size_t> indices(const Selection::Range& range, std::size_t count);

/// Returns the elements of the list that the range names. This is the part of a field that has no layout.
template <class Element>
std::vector<Element> cut(const std::vector<Element>& list, const Selection::Range& range) {
  std::vector<Element> part;
  for (const std::size_t i : indices(range, list.size())) part.push_back(list[i]);
  return part;
}

/// These functions return the message with the given part of its `data`. They ignore the number of the leaf
/// in the part, so that the message may also be a member of another message.
sensor_msgs::msg::PointCloud2 cut(const sensor_msgs::msg::PointCloud2& cloud, const Selection::Part& part);
sensor_msgs::msg::Image cut(const sensor_msgs::msg::Image& image, const Selection::Part& part);
nav_msgs::msg::OccupancyGrid cut(const nav_msgs::msg::OccupancyGrid& grid, const Selection::Part& part);

/// Returns the scan with the parts of `ranges` and `intensities` that the selection has.
sensor_msgs::msg::LaserScan cut(const sensor_msgs::msg::LaserScan& scan, const Selection& selection);
inline constexpr std::size_t ranges_leaf = 10;       ///< the number of the leaf in LaserScan
inline constexpr std::size_t intensities_leaf = 11;  ///< the number of the leaf in LaserScan

/// Returns the descriptions of the cloud's channels with these names, in the order of their offsets.
std::vector<sensor_msgs::msg::PointField> channels_of(const sensor_msgs::msg::PointCloud2& cloud,
                                                      const std::vector<std::string>& names);
/// Returns the size in bytes of an element of one of the eight types of channels; 0 for other types.
std::size_t bytes_of_datatype(std::uint8_t datatype);

/// Returns the size in bytes of a pixel in an encoding of sensor_msgs/image_encodings. Returns nothing for
/// encodings in planes and for unknown names.
std::optional<std::size_t> bytes_of_encoding(const std::string& encoding);

}  // namespace sft::test::cut_reference
