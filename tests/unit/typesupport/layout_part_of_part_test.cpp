// Parts of parts of cells, records, points and pictures with a layout rule of the user. Two steps take, byte
// by byte, the same part as one step with the combined selection.
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <layout_msgs/msg/Cells.hpp>
#include <layout_msgs/msg/Packet.hpp>
#include <layout_msgs/msg/Picture.hpp>
#include <layouts.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/cut_reference.h"
#include "tests/unit/typesupport/part_of_part.h"

namespace sft {
namespace {

using layout_msgs::msg::Cells;
using layout_msgs::msg::Packet;
using layout_msgs::msg::Picture;
using nav_msgs::msg::OccupancyGrid;
using sensor_msgs::msg::Image;
using sensor_msgs::msg::PointCloud2;
using sensor_msgs::msg::PointField;

class UserPartsOfParts : public PartOfPartTest {
 protected:
  /// Sometimes changes one of the numbers, so that the message contradicts itself.
  void lie_about(std::span<std::uint32_t* const> members) {
    constexpr std::array lies{0U, 1U, 1U << 20, ~0U};
    if (!layouts.one_in(6)) return;
    std::uint32_t& number = *members[layouts.below(members.size())];
    number = layouts.one_in(2) ? number + 1 : lies[layouts.below(lies.size())];
  }
};

// ---- cells without a place ----

TEST_F(UserPartsOfParts, OfCellsMayHaveDifferentStepsInRowsAndColumns) {
  Cells table;
  table.rows = 4;
  table.columns = 5;
  for (int cell = 0; cell < 20; ++cell) table.cells.push_back(cell);
  const Steps steps = steps_by_text<Cells>("cells[rows 1:, columns ::2]", "cells[rows ::2, columns 1:]",
                                           "cells[rows 1::2, columns 2::2]");
  const Cells some = expect_same_bytes(table, steps).message();
  EXPECT_EQ(some.cells, (std::vector<double>{7, 9, 17, 19}));
  EXPECT_EQ(some.rows, 2U);
  EXPECT_EQ(some.columns, 2U);
}

TEST_F(UserPartsOfParts, OfCellsAreThoseOfTheSelectionOfBoth) {
  int with_cells = 0;
  for (int round = 0; round < rounds() && !HasFailure(); ++round) {
    SCOPED_TRACE("round " + std::to_string(round));
    const OccupancyGrid grid = layouts.grid();
    Cells table;
    table.rows = grid.info.height;
    table.columns = grid.info.width;
    lie_about(std::array{&table.rows, &table.columns});
    for (const std::int8_t cell : grid.data) table.cells.push_back(cell);
    const Steps steps = any_steps<Cells>("cells", grid.info.height, grid.info.width);
    const Cells some = expect_same_bytes(table, steps).message();
    with_cells += some.cells.empty() ? 0 : 1;
    const bool is_part = !steps.both.parts().empty();
    if (!is_part ||
        !lacks_room(table.rows, table.columns, 8, std::uint64_t{table.columns} * 8, table.cells.size() * 8))
      continue;
    EXPECT_TRUE(some.cells.empty() && some.rows == 0 && some.columns == 0);
  }
  EXPECT_GT(with_cells, rounds() / 4) << "else the parts are dull";
}

// ---- records of bytes ----

/// Expects a part of records to have the packet's byte order, and to be empty if the packet contradicts
/// itself.
void expect_honest_part(const Packet& packet, const Taken<Packet>& some, const Steps& steps) {
  if (steps.both.parts().empty()) return;
  EXPECT_TRUE(some.mask().contains(*type_support<Packet>().find("is_bigendian")));
  const Packet part = some.message();
  EXPECT_EQ(part.is_bigendian, packet.is_bigendian);
  EXPECT_EQ(part.records.size(), std::size_t{part.lines} * part.line_bytes);
  if (!lacks_room(packet.lines, packet.columns, packet.record_bytes, packet.line_bytes,
                  packet.records.size()))
    return;
  EXPECT_TRUE(part.records.empty() && part.lines == 0 && part.columns == 0 && part.line_bytes == 0);
}

TEST_F(UserPartsOfParts, OfRecordsOfBytesAreThoseOfTheSelectionOfBothAndTellTheirByteOrder) {
  int with_records = 0;
  for (int round = 0; round < rounds() && !HasFailure(); ++round) {
    SCOPED_TRACE("round " + std::to_string(round));
    const PointCloud2 cloud = layouts.cloud();
    Packet packet;
    packet.lines = cloud.height;
    packet.columns = cloud.width;
    packet.record_bytes = cloud.point_step;
    packet.line_bytes = cloud.row_step;
    lie_about(std::array{&packet.lines, &packet.columns, &packet.record_bytes, &packet.line_bytes});
    packet.is_bigendian = cloud.is_bigendian;
    packet.records = cloud.data;
    const Steps steps = any_steps<Packet>("records", cloud.height, cloud.width);
    const Taken<Packet> some = expect_same_bytes(packet, steps);
    expect_honest_part(packet, some, steps);
    with_records += some.message().records.empty() ? 0 : 1;
  }
  EXPECT_GT(with_records, rounds() / 4);
}

TEST_F(UserPartsOfParts, OfRecordsInIdlHaveNoGapsAfterTheFirstStep) {
  layouts::Records whole;
  whole.lines = 4;
  whole.width = 3;
  whole.record_bytes = 2;
  whole.line_bytes = 8;  // two bytes of each line are padding
  for (std::uint8_t i = 0; i < 32; ++i) whole.records.push_back(i);
  const Steps steps = steps_by_text<layouts::Records>(
      "records[rows 1:, columns 1:]", "records[rows ::2, columns 1]", "records[rows 1::2, columns 2]");
  const layouts::Records some = expect_same_bytes(whole, steps).message();
  EXPECT_EQ(some.records, (std::vector<std::uint8_t>{12, 13, 28, 29}));
  EXPECT_EQ(some.lines, 2U);
  EXPECT_EQ(some.width, 1U);
  EXPECT_EQ(some.record_bytes, 2U);
  EXPECT_EQ(some.line_bytes, 2U);
}

// ---- points ----

class UserPointsOfPoints : public UserPartsOfParts {
 protected:
  /// Returns the first row of a cloud.
  static layouts::Points points_of(const PointCloud2& cloud) {
    layouts::Points points;
    points.width = cloud.width;
    points.point_bytes = cloud.point_step;
    points.points = cloud.data;
    for (const PointField& field : cloud.fields) {
      layouts::Channel& channel = points.channels.emplace_back();
      channel.name = field.name;
      channel.offset = field.offset;
      channel.type = field.datatype;
      channel.count = field.count;
    }
    return points;
  }
  Part any_part_of_points(std::uint32_t columns) {
    Part part{.columns = any_range(columns)};
    if (!layouts.one_in(3)) part.channels = layouts.channels();
    return part;
  }
  /// Returns true if the first step has readable channels that together are not larger than a point.
  static bool has_points_between(const PointCloud2& cloud, const Part& first) {
    if (first.channels.empty()) return true;
    std::uint64_t bytes = 0;
    for (const PointField& field : test::cut_reference::channels_of(cloud, first.channels))
      bytes += std::uint64_t{test::cut_reference::bytes_of_datatype(field.datatype)} * field.count;
    return bytes > 0 && bytes <= cloud.point_step;
  }
};

TEST_F(UserPointsOfPoints, HaveTheChannelsThatBothStepsName) {
  int with_points = 0;
  for (int round = 0; round < 2 * rounds() && !HasFailure(); ++round) {
    SCOPED_TRACE("round " + std::to_string(round));
    const PointCloud2 cloud = layouts.cloud();
    const Part first = any_part_of_points(cloud.width);
    if (!has_points_between(cloud, first)) continue;
    const Part second = any_part_of_points(first.columns.size_of(cloud.width));
    layouts::Points points = points_of(cloud);
    const bool contradicts_itself = layouts.one_in(8);
    if (contradicts_itself) points.points.resize(std::size_t{points.width} * points.point_bytes - 1);
    const Steps steps = steps_of<layouts::Points>("points", first, second);
    const layouts::Points some = expect_same_bytes(points, steps).message();
    with_points += some.points.empty() ? 0 : 1;
    if (!contradicts_itself || steps.both.parts().empty()) continue;
    EXPECT_TRUE(some.points.empty() && some.width == 0);
  }
  EXPECT_GT(with_points, rounds() / 4);
}

// ---- pictures ----

class UserPicturesOfPictures : public UserPartsOfParts {
 protected:
  static Picture picture_of(const Image& image) {
    Picture picture;
    picture.lines = image.height;
    picture.columns = image.width;
    picture.line_bytes = image.step;
    picture.is_bigendian = image.is_bigendian != 0;
    picture.format = image.encoding;
    picture.pixels = image.data;
    return picture;
  }

  /// Returns true if the part cannot be a picture of that format, so that the picture stays whole.
  static bool stays_whole(std::string_view format, const Part& part, std::uint32_t columns) {
    if (format.starts_with("nv")) return true;
    if (format.starts_with("bayer_")) return part.rows.step % 2 == 0 || part.columns.step % 2 == 0;
    if (!format.starts_with("yu") && format != "uyvy") return false;
    return part.columns.step != 1 || part.columns.begin % 2 != 0 || part.columns.size_of(columns) % 2 != 0;
  }
  /// Returns true if two rules contradict each other for a picture that would stay whole: the part is empty,
  /// or only one index of a step is left.
  static bool is_ambiguous(const Part& part, std::uint32_t rows, std::uint32_t columns) {
    const std::uint32_t some_rows = part.rows.size_of(rows), some_columns = part.columns.size_of(columns);
    return some_rows == 0 || some_columns == 0 || (some_rows == 1 && part.rows.step != 1) ||
           (some_columns == 1 && part.columns.step != 1);
  }

  /// Compares two steps with one step. Returns the number of bytes of the pixels; 0 if the rules contradict
  /// each other.
  std::size_t expect_same_picture(const Picture& picture) {
    std::uint32_t rows = picture.lines, columns = picture.columns;
    Part both;
    std::array<Part, 2> parts;
    for (Part& part : parts) {
      part = any_part(rows, columns);
      part.rows = part.rows.canonical();
      part.columns = part.columns.canonical();
      if (stays_whole(picture.format, part, columns)) {
        if (is_ambiguous(part, rows, columns)) return 0;
        continue;
      }
      both = together(both, part);
      rows = part.rows.size_of(rows);
      columns = part.columns.size_of(columns);
    }
    const Steps steps = steps_of<Picture>(
        {{.leaf = pixels, .rows = parts[0].rows, .columns = parts[0].columns}},
        {{.leaf = pixels, .rows = parts[1].rows, .columns = parts[1].columns}},
        [&](const Selection&, const Selection&) {
          return std::vector<Part>{{.leaf = pixels, .rows = both.rows, .columns = both.columns}};
        });
    const Taken<Picture> whole(picture);
    const Taken<Picture> two = whole.part(steps.first).part(steps.second), one = whole.part(steps.both);
    Picture of_two = two.message();
    const Picture of_one = one.message();
    // a pattern without pixels may begin with any colour
    if (of_one.pixels.empty()) of_two.format = of_one.format;
    EXPECT_TRUE(is_same(Taken<Picture>(of_two, two.mask()), one))
        << words<Picture>(steps) << " of " << picture.format;
    EXPECT_EQ(of_two.is_bigendian, one.mask().contains(byte_order) && picture.is_bigendian);
    return both.is_whole() ? 0 : of_one.pixels.size();
  }

  const std::uint32_t pixels = leaf<Picture>("pixels"), byte_order = leaf<Picture>("is_bigendian");
};

TEST_F(UserPicturesOfPictures, AreThoseOfTheSelectionOfTheStepsThatLeaveAPicture) {
  int with_pixels = 0;
  for (int round = 0; round < 2 * rounds() && !HasFailure(); ++round) {
    SCOPED_TRACE("round " + std::to_string(round));
    const Image image = layouts.image();
    const bool is_known = test::cut_reference::bytes_of_encoding(image.encoding).has_value();
    if (!is_known && !image.encoding.starts_with("nv")) continue;
    with_pixels += expect_same_picture(picture_of(image)) > 0 ? 1 : 0;
  }
  EXPECT_GT(with_pixels, rounds() / 4);
}

TEST_F(UserPicturesOfPictures, OfAnUnknownFormatHaveTheBytesOfAPixelThatTheFirstStepLeft) {
  for (int round = 0; round < rounds() / 4 && !HasFailure(); ++round) {
    SCOPED_TRACE("round " + std::to_string(round));
    Picture picture = picture_of(layouts.image("rgb8"));
    picture.format = "thermal";
    picture.line_bytes = picture.columns * 3;
    picture.pixels = numbers<std::uint8_t>(std::size_t{picture.lines} * picture.line_bytes);
    const Part first{.rows = layouts.range_with_some(picture.lines),
                     .columns = layouts.range_with_some(picture.columns)};
    const Part second{.rows = layouts.range_with_some(first.rows.size_of(picture.lines)),
                      .columns = layouts.range_with_some(first.columns.size_of(picture.columns))};
    const Picture some = expect_same_bytes(picture, steps_of<Picture>("pixels", first, second)).message();
    EXPECT_FALSE(some.pixels.empty());
  }
}

}  // namespace
}  // namespace sft
