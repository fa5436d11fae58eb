// The law of parts of messages with layouts: a projection of a part equals, byte by byte, the encoding of the
// message that the reference cuts.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <nav_msgs/msg/OccupancyGrid.hpp>
#include <sensor_msgs/msg/Image.hpp>
#include <sensor_msgs/msg/LaserScan.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tests/support/cut.h"
#include "tests/support/cut_reference.h"
#include "tests/support/random_layouts.h"
#include "tests/support/random_value.h"

namespace sft {

using nav_msgs::msg::OccupancyGrid;
using sensor_msgs::msg::Image;
using sensor_msgs::msg::LaserScan;
using sensor_msgs::msg::PointCloud2;
using test::Cut;
using test::is_encoded;
namespace cut_reference = test::cut_reference;

/// Adapts `expected` to `taken` if two results are right: a part without bytes may have the rows and
/// columns of its ranges, or 0 rows and 0 columns.
inline void settle(const PointCloud2& taken, PointCloud2& expected) {
  if (!expected.data.empty()) return;
  if (expected.height == 0 && taken.row_step == 0) expected.row_step = 0;
  if (taken.height == 0 && taken.width == 0) expected.height = expected.width = expected.row_step = 0;
}

/// Adapts `expected` for the same reason. In addition, a Bayer pattern without pixels may begin with any
/// colour.
inline void settle(const Image& taken, Image& expected) {
  if (!expected.data.empty()) return;
  if (expected.height == 0 && taken.step == 0) expected.step = 0;
  if (taken.height == 0 && taken.width == 0) expected.height = expected.width = expected.step = 0;
  if (expected.encoding.starts_with("bayer_")) {
    EXPECT_TRUE(cut_reference::bytes_of_encoding(taken.encoding)) << taken.encoding;
    expected.encoding = taken.encoding;
  }
}

/// Adapts `expected` for the same reason. In addition, the reference rotates by another formula, which
/// rounds differently, and a grid without cells may have any origin.
inline void settle(const OccupancyGrid& taken, OccupancyGrid& expected) {
  const auto& at = taken.info.origin.position;
  auto& right = expected.info.origin.position;
  if (expected.data.empty()) {
    if (taken.info.height == 0 && taken.info.width == 0) expected.info.height = expected.info.width = 0;
  } else {
    EXPECT_NEAR(at.x, right.x, 1e-11);
    EXPECT_NEAR(at.y, right.y, 1e-11);
    EXPECT_NEAR(at.z, right.z, 1e-11);
  }
  right = at;
}

/// Returns false if two rules of the specification contradict each other. This happens if the part is empty
/// and the image would stay whole. It also happens if only the first index of a step is within the image.
inline bool is_settled(const Image& image, const Selection::Part& part) {
  const std::uint32_t rows = part.rows.size_of(image.height), columns = part.columns.size_of(image.width);
  const bool is_named = cut_reference::bytes_of_encoding(image.encoding).has_value();
  if (is_named && !image.encoding.starts_with("bayer_") && !image.encoding.ends_with("uyvy") &&
      !image.encoding.starts_with("yu"))
    return true;
  if (rows == 0 || columns == 0) return false;
  return (rows > 1 || part.rows.step == 1) && (columns > 1 || part.columns.step == 1);
}

class CutLawTest : public test::RandomTest {
 protected:
  using Part = Selection::Part;
  using Range = Selection::Range;

  template <class T>
  static std::uint32_t leaf(std::string_view path) {
    return static_cast<std::uint32_t>(*type_support<T>().find(path).value().begin());
  }

  /// Returns a selection of the given parts and of random other fields.
  template <class T>
  Selection with_other_fields(std::vector<Part> parts) {
    FieldMask mask = values.mask(type_support<T>().leaves());
    return Selection::make(std::move(mask), std::move(parts), {}).value();
  }

  template <class T>
  static Selection parsed(std::string_view text) {
    return type_support<T>().parse_selection(text).value();
  }

  template <class T>
  static std::string words(const Selection& selection) {
    return "the selection '" + type_support<T>().format_selection(selection) + "'";
  }

  Part part_of_cloud(const PointCloud2& cloud) {
    Part part{.leaf = leaf<PointCloud2>("data"),
              .rows = layouts.range(cloud.height),
              .columns = layouts.range(cloud.width)};
    if (!layouts.one_in(3)) part.channels = layouts.channels();
    return part;
  }

  // Each of the functions below expects that a projection equals, byte by byte, the part that the reference
  // cuts.

  void expect_points(const PointCloud2& cloud, const Part& wanted) {
    const Selection selection = with_other_fields<PointCloud2>({wanted});
    const Part* part = selection.part(wanted.leaf);
    PointCloud2 expected = part == nullptr ? cloud : cut_reference::cut(cloud, *part);
    const Cut<PointCloud2> cut(cloud, selection);
    settle(cut.decoded(cloud), expected);
    ASSERT_TRUE(is_encoded(expected, cut)) << words<PointCloud2>(selection);
  }

  void expect_pixels(const Image& image) {
    const Selection selection = with_other_fields<Image>({{.leaf = leaf<Image>("data"),
                                                           .rows = layouts.range(image.height),
                                                           .columns = layouts.range(image.width)}});
    const Part* part = selection.part(leaf<Image>("data"));
    if (part != nullptr && !is_settled(image, *part)) return;
    Image expected = part == nullptr ? image : cut_reference::cut(image, *part);
    const Cut<Image> cut(image, selection);
    settle(cut.decoded(image), expected);
    ASSERT_TRUE(is_encoded(expected, cut)) << words<Image>(selection) << " and an image of " << image.height
                                           << " x " << image.width << " pixels '" << image.encoding << "'";
  }

  void expect_cells(const OccupancyGrid& grid) {
    Part wanted{.leaf = leaf<OccupancyGrid>("data"),
                .rows = layouts.range(grid.info.height),
                .columns = layouts.range(grid.info.width)};
    if (!layouts.one_in(5)) wanted.columns.step = wanted.rows.step;
    const Selection selection = with_other_fields<OccupancyGrid>({wanted});
    const Part* part = selection.part(leaf<OccupancyGrid>("data"));
    OccupancyGrid expected = part == nullptr ? grid : cut_reference::cut(grid, *part);
    if (part != nullptr && part->rows.step != part->columns.step) {
      const bool is_empty =
          part->rows.size_of(grid.info.height) == 0 || part->columns.size_of(grid.info.width) == 0;
      if (is_empty) return;  // both an empty grid and the whole grid would be right
    }
    const Cut<OccupancyGrid> cut(grid, selection);
    if (part != nullptr) settle(cut.decoded(grid), expected);
    ASSERT_TRUE(is_encoded(expected, cut)) << words<OccupancyGrid>(selection);
  }

  void expect_beams(const LaserScan& scan) {
    const auto beams = static_cast<std::uint32_t>(scan.ranges.size());
    const Part ranges{.leaf = leaf<LaserScan>("ranges"), .columns = layouts.range(beams)};
    Part intensities{.leaf = leaf<LaserScan>("intensities"), .columns = ranges.columns};
    if (layouts.one_in(3)) intensities.columns = layouts.range(beams);
    std::vector<Part> parts;
    if (!layouts.one_in(4)) parts.push_back(ranges);
    if (parts.empty() || layouts.one_in(2)) parts.push_back(intensities);
    const Selection selection = with_other_fields<LaserScan>(parts);
    LaserScan expected = cut_reference::cut(scan, selection);
    const Cut<LaserScan> cut(scan, selection);
    const bool has_ranges = selection.mask().contains(ranges.leaf);
    if ((has_ranges ? expected.ranges : expected.intensities).empty()) {
      // Without beams there is no first and no last angle.
      const LaserScan taken = cut.decoded(expected);
      EXPECT_TRUE(std::isfinite(taken.angle_min) && std::isfinite(taken.angle_max));
      expected.angle_min = taken.angle_min;
      expected.angle_max = taken.angle_max;
    }
    ASSERT_TRUE(is_encoded(expected, cut)) << words<LaserScan>(selection) << " and " << beams << " beams";
  }

  test::RandomLayouts layouts{random};
  test::RandomValues values{random};
};

}  // namespace sft
