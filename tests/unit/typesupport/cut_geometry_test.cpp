// The geometry of parts: points, pixels, cells and beams keep their values and places. A part of a part
// equals the part that both ranges together name. The tests do not use the reference (cut_reference.h).
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <nav_msgs/msg/OccupancyGrid.hpp>
#include <sensor_msgs/msg/Image.hpp>
#include <sensor_msgs/msg/LaserScan.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <string>
#include <string_view>

#include "tests/support/cut.h"
#include "tests/support/cut_reference.h"
#include "tests/support/random_layouts.h"

#ifndef SFT_TEST_ROUNDS
#define SFT_TEST_ROUNDS 1000
#endif

namespace sft {
namespace {

using nav_msgs::msg::OccupancyGrid;
using sensor_msgs::msg::Image;
using sensor_msgs::msg::LaserScan;
using sensor_msgs::msg::PointCloud2;
using sensor_msgs::msg::PointField;
using test::Cut;

class CutGeometry : public test::RandomTest {
 protected:
  using Part = Selection::Part;
  using Range = Selection::Range;

  static int rounds() { return static_cast<int>(test::test_rounds(SFT_TEST_ROUNDS)); }

  /// Returns a selection of the whole message, with only the given part of one field.
  template <class T>
  static Selection selection(std::string_view path, Part part) {
    const TypeSupport& type = type_support<T>();
    part.leaf = static_cast<std::uint32_t>(*type.find(path).value().begin());
    return Selection::make(type.full(), {std::move(part)}, {}).value();
  }
  template <class T>
  static T taken(const T& whole, std::string_view path, const Part& part) {
    const Cut<T> cut(whole, selection<T>(path, part));
    EXPECT_TRUE(cut.ok());
    return cut.ok() ? cut.decoded() : T{};
  }

  test::RandomLayouts layouts{random};
};

/// Returns the first channel with this name, or null if that channel cannot be read.
const PointField* readable_channel(const PointCloud2& cloud, std::string_view name) {
  constexpr std::array<std::uint64_t, 9> bytes{0, 1, 1, 2, 2, 4, 4, 4, 8};
  const auto field = std::ranges::find(cloud.fields, name, &PointField::name);
  if (field == cloud.fields.end() || field->datatype >= bytes.size()) return nullptr;
  const std::uint64_t size = bytes[field->datatype] * field->count;
  return size == 0 || field->offset + size > cloud.point_step ? nullptr : &*field;
}

/// Returns true if channels overlap so much that the part's points would be larger than the cloud's points.
bool larger_than_the_point(const PointCloud2& cloud, const Selection::Part& part) {
  std::uint64_t bytes = 0;
  for (const std::string& name : part.channels) {
    const PointField* field = readable_channel(cloud, name);
    if (field != nullptr) bytes += test::cut_reference::bytes_of_datatype(field->datatype) * field->count;
  }
  return bytes > cloud.point_step;
}

double coordinate(const PointCloud2& cloud, const PointField& field, std::size_t row, std::size_t column) {
  const std::uint8_t* at =
      cloud.data.data() + row * cloud.row_step + column * cloud.point_step + field.offset;
  if (field.datatype == PointField::FLOAT64) {
    double value;
    std::memcpy(&value, at, sizeof value);
    return value;
  }
  float value;
  std::memcpy(&value, at, sizeof value);
  return value;
}

bool is_same_number(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

TEST_F(CutGeometry, PointsKeepTheirCoordinates) {
  for (int round = 0; round < rounds(); ++round) {
    const PointCloud2 whole = layouts.cloud();
    Part part{.rows = layouts.range_with_some(whole.height), .columns = layouts.range_with_some(whole.width)};
    if (!layouts.one_in(4)) part.channels = {"x", "y", "z", "absent"};
    if (part.is_whole()) continue;
    const PointCloud2 some = taken(whole, "data", part);
    const bool has_any = readable_channel(whole, "x") != nullptr || readable_channel(whole, "y") != nullptr ||
                         readable_channel(whole, "z") != nullptr;
    if (!has_any || larger_than_the_point(whole, part)) continue;
    ASSERT_EQ(some.height, part.rows.size_of(whole.height));
    ASSERT_EQ(some.width, part.columns.size_of(whole.width));
    ASSERT_GE(some.row_step, some.width * some.point_step);
    ASSERT_EQ(some.data.size(), std::size_t{some.height} * some.row_step);
    for (const char* name : {"x", "y", "z"}) {
      const PointField* in_whole = readable_channel(whole, name);
      const PointField* in_some = readable_channel(some, name);
      ASSERT_EQ(in_whole == nullptr, in_some == nullptr) << name;
      if (in_whole == nullptr || in_whole->datatype < PointField::FLOAT32) continue;
      ASSERT_EQ(in_whole->datatype, in_some->datatype);
      for (std::size_t row = 0; row < some.height; ++row) {
        for (std::size_t column = 0; column < some.width; ++column) {
          const double before = coordinate(whole, *in_whole, part.rows.begin + row * part.rows.step,
                                           part.columns.begin + column * part.columns.step);
          ASSERT_TRUE(is_same_number(coordinate(some, *in_some, row, column), before))
              << name << " of point " << row << ", " << column << " in round " << round;
        }
      }
    }
  }
}

TEST_F(CutGeometry, ChannelsLieBehindOneAnotherInTheOrderOfTheirOffsets) {
  PointCloud2 cloud;
  cloud.height = cloud.width = 1;
  cloud.point_step = cloud.row_step = 26;
  for (std::uint8_t i = 0; i < 26; ++i) cloud.data.push_back(i);
  const auto add = [&](const char* name, std::uint32_t offset, std::uint8_t datatype, std::uint32_t count) {
    PointField field;
    field.name = name;
    field.offset = offset;
    field.datatype = datatype;
    field.count = count;
    cloud.fields.push_back(field);
  };
  add("time", 17, PointField::FLOAT64, 1);
  add("ring", 13, PointField::UINT16, 2);
  add("x", 1, PointField::FLOAT32, 1);
  add("x", 9, PointField::FLOAT64, 1);
  add("low", 1, PointField::UINT8, 1);
  const PointCloud2 some = taken(cloud, "data", {.channels = {"low", "ring", "time", "x"}});
  EXPECT_EQ(some.point_step, 4U + 1 + 4 + 8);
  EXPECT_EQ(some.row_step, some.point_step);
  std::vector<std::string> fields;
  for (const PointField& f : some.fields)
    fields.push_back(f.name + " " + std::to_string(f.offset) + " " + std::to_string(f.datatype) + " " +
                     std::to_string(f.count));
  EXPECT_EQ(fields, (std::vector<std::string>{"x 0 7 1", "low 4 2 1", "ring 5 4 2", "time 9 8 1"}));
  EXPECT_EQ(some.data,
            (std::vector<std::uint8_t>{1, 2, 3, 4, 1, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24}));
}

TEST_F(CutGeometry, ACloudWithoutTheChannelsHasNoBytesAndDescribesNone) {
  for (int round = 0; round < rounds() / 10; ++round) {
    const PointCloud2 some = taken(layouts.cloud(), "data", {.channels = {"absent", "other"}});
    EXPECT_TRUE(some.data.empty());
    EXPECT_TRUE(some.fields.empty());
    EXPECT_EQ(some.point_step, 0U);
    EXPECT_EQ(some.row_step, 0U);
  }
}

/// Returns the corner of a cell, computed with the matrix of the rotation.
std::array<double, 3> corner(const OccupancyGrid& grid, double row, double column) {
  const auto& q = grid.info.origin.orientation;
  const auto& p = grid.info.origin.position;
  const double x = column * double{grid.info.resolution}, y = row * double{grid.info.resolution};
  return {p.x + (1 - 2 * (q.y * q.y + q.z * q.z)) * x + 2 * (q.x * q.y - q.w * q.z) * y,
          p.y + 2 * (q.x * q.y + q.w * q.z) * x + (1 - 2 * (q.x * q.x + q.z * q.z)) * y,
          p.z + 2 * (q.x * q.z - q.w * q.y) * x + 2 * (q.y * q.z + q.w * q.x) * y};
}

TEST_F(CutGeometry, CellsKeepTheirLowerLeftCorners) {
  for (int round = 0; round < rounds() / 2; ++round) {
    const OccupancyGrid whole = layouts.grid();
    Part part{.rows = layouts.range_with_some(whole.info.height),
              .columns = layouts.range_with_some(whole.info.width)};
    part.columns.step = part.rows.step;
    part.rows = part.rows.canonical();
    part.columns = part.columns.canonical();
    if (part.columns.step != part.rows.step) continue;
    const OccupancyGrid some = taken(whole, "data", part);
    ASSERT_EQ(some.info.height, part.rows.size_of(whole.info.height));
    ASSERT_EQ(some.info.width, part.columns.size_of(whole.info.width));
    const std::size_t cells = std::size_t{some.info.height} * some.info.width;
    // The resolution of a part is rounded to a float. The place of a cell is a multiple of the resolution,
    // so its error grows with the number of cells up to that place. The limit of the error is that of the
    // farthest cell.
    const double size = double{whole.info.resolution} * (whole.info.height + whole.info.width);
    for (std::size_t cell = 0; cell < cells; ++cell) {
      const std::size_t row = cell / some.info.width, column = cell % some.info.width;
      const std::size_t whole_row = part.rows.begin + row * part.rows.step;
      const std::size_t whole_column = part.columns.begin + column * part.columns.step;
      ASSERT_EQ(some.data.at(cell), whole.data.at(whole_row * whole.info.width + whole_column));
      const auto at = corner(some, static_cast<double>(row), static_cast<double>(column));
      const auto was = corner(whole, static_cast<double>(whole_row), static_cast<double>(whole_column));
      for (std::size_t i = 0; i < 3; ++i)
        ASSERT_NEAR(at[i], was[i], 1e-11 + size * 1.2e-7)
            << "axis " << i << " of cell " << cell << " in round " << round;
    }
  }
}

TEST_F(CutGeometry, AGridWithDifferentStepsStaysWhole) {
  const OccupancyGrid whole = layouts.grid();
  EXPECT_EQ(taken(whole, "data", {.rows = {.step = 2}, .columns = {.step = 3}}), whole);
  EXPECT_EQ(taken(whole, "data", {.columns = {.step = 3}}), whole);
}

/// Returns two units in the last place of the largest angle, or of the span of the beams if that is larger.
double two_ulp(const LaserScan& scan) {
  const double last = double{scan.angle_min} + double{scan.angle_increment} * double(scan.ranges.size());
  const double span = std::abs(last - double{scan.angle_min});
  const auto largest = static_cast<float>(std::max({std::abs(double{scan.angle_min}), std::abs(last), span}));
  return 2 * (std::nextafter(largest, std::numeric_limits<float>::infinity()) - largest);
}

double angle_of(const LaserScan& scan, std::size_t beam) {
  return double{scan.angle_min} + static_cast<double>(beam) * double{scan.angle_increment};
}

TEST_F(CutGeometry, BeamsKeepTheirAngles) {
  for (int round = 0; round < rounds(); ++round) {
    const LaserScan whole = layouts.scan();
    const auto beams = static_cast<std::uint32_t>(whole.ranges.size());
    const TypeSupport& type = type_support<LaserScan>();
    const Range range = layouts.range_with_some(beams).canonical();
    const auto ranges = static_cast<std::uint32_t>(*type.find("ranges").value().begin());
    const Selection both =
        Selection::make(type.full(),
                        {{.leaf = ranges, .columns = range}, {.leaf = ranges + 1, .columns = range}}, {})
            .value();
    const Cut<LaserScan> cut(whole, both);
    ASSERT_TRUE(cut.ok());
    const LaserScan some = cut.decoded();
    ASSERT_EQ(some.ranges.size(), range.size_of(beams));
    ASSERT_EQ(some.intensities.empty(), whole.intensities.empty());
    for (std::size_t beam = 0; beam < some.ranges.size(); ++beam) {
      const std::size_t before = range.begin + beam * range.step;
      ASSERT_EQ(some.ranges[beam], whole.ranges[before]);
      if (!whole.intensities.empty()) {
        ASSERT_EQ(some.intensities.at(beam), whole.intensities[before]);
      }
      ASSERT_NEAR(angle_of(some, beam), angle_of(whole, before), two_ulp(whole)) << "in round " << round;
    }
    ASSERT_NEAR(some.angle_max, angle_of(some, some.ranges.size() - 1), two_ulp(whole));
    ASSERT_FLOAT_EQ(some.time_increment, whole.time_increment * static_cast<float>(range.step));
    ASSERT_EQ(some.header, whole.header);
    ASSERT_EQ(some.scan_time, whole.scan_time);
  }
}

/// Returns the letter of a pixel's colour. The letters of two rows follow "bayer_".
char colour(const Image& image, std::size_t row, std::size_t column) {
  return image.encoding.at(6 + row % 2 * 2 + column % 2);
}

TEST_F(CutGeometry, PixelsKeepTheirBytesAndTheirColours) {
  for (int round = 0; round < rounds(); ++round) {
    const bool is_bayer = layouts.one_in(2);
    const std::array bayer{"bayer_rggb8", "bayer_bggr8", "bayer_gbrg16", "bayer_grbg16"};
    const std::array packed{"mono8", "mono16", "rgb8", "bgra8", "32FC1"};
    constexpr std::array<std::size_t, 5> packed_bytes{1, 2, 3, 4, 4};
    const std::uint32_t which = layouts.below(is_bayer ? bayer.size() : packed.size());
    const std::size_t bytes = is_bayer ? 1 + which / 2 : packed_bytes[which];
    const Image whole = layouts.image(is_bayer ? bayer[which] : packed[which]);
    Part part{.rows = layouts.range_with_some(whole.height), .columns = layouts.range_with_some(whole.width)};
    part.rows = part.rows.canonical();
    part.columns = part.columns.canonical();
    if (is_bayer && (part.rows.step % 2 == 0 || part.columns.step % 2 == 0)) continue;
    if (part.is_whole()) continue;
    const Image some = taken(whole, "data", part);
    ASSERT_EQ(some.height, part.rows.size_of(whole.height));
    ASSERT_EQ(some.width, part.columns.size_of(whole.width));
    ASSERT_EQ(some.step, some.width * bytes);
    ASSERT_EQ(some.data.size(), std::size_t{some.height} * some.step);
    const std::size_t letters = is_bayer ? 10 : 0;  // the letters of the colours may change in a part
    ASSERT_EQ(some.encoding.substr(letters), whole.encoding.substr(letters));
    for (std::size_t row = 0; row < some.height; ++row) {
      for (std::size_t column = 0; column < some.width; ++column) {
        const std::size_t whole_row = part.rows.begin + row * part.rows.step;
        const std::size_t whole_column = part.columns.begin + column * part.columns.step;
        ASSERT_EQ(std::memcmp(some.data.data() + row * some.step + column * bytes,
                              whole.data.data() + whole_row * whole.step + whole_column * bytes, bytes),
                  0);
        if (!is_bayer) continue;
        ASSERT_EQ(colour(some, row, column), colour(whole, whole_row, whole_column));
      }
    }
  }
}

TEST_F(CutGeometry, ImagesOfWhichNoPartIsAnImageStayWhole) {
  const Part some_rows{.rows = {.begin = 1}}, every_second{.columns = {.step = 2}};
  for (const char* encoding : {"nv12", "nv21", "nv24"}) {
    const Image image = layouts.image(encoding);
    EXPECT_EQ(taken(image, "data", some_rows), image) << encoding;
    EXPECT_EQ(taken(image, "data", every_second), image) << encoding;
  }
  for (const char* encoding : {"yuv422", "yuv422_yuy2", "uyvy", "yuyv"}) {
    Image image = layouts.image(encoding);
    image.height = 4;
    image.width = 8;
    image.step = 17;
    image.data.assign(68, 1);
    EXPECT_EQ(taken(image, "data", every_second), image) << encoding;
    EXPECT_EQ(taken(image, "data", {.columns = {.begin = 1}}), image) << encoding;
    EXPECT_EQ(taken(image, "data", {.columns = {.end = 5}}), image) << encoding;
    const Image even = taken(image, "data", {.rows = {.begin = 1}, .columns = {.begin = 2, .end = 6}});
    EXPECT_EQ(even.height, 3U);
    EXPECT_EQ(even.width, 4U);
    EXPECT_EQ(even.step, 8U);
    EXPECT_EQ(even.encoding, encoding);
  }
  Image image = layouts.image("bayer_rggb8");
  image.height = 4;
  image.width = 4;
  image.step = 4;
  image.data.assign(16, 1);
  EXPECT_EQ(taken(image, "data", every_second), image);
  EXPECT_EQ(taken(image, "data", {.rows = {.step = 2}}), image);
  image.encoding = "nobody knows";
  image.data.push_back(1);
  EXPECT_EQ(taken(image, "data", some_rows), image) << "there is a byte too much";
  image.data.pop_back();
  image.width = 3;
  EXPECT_EQ(taken(image, "data", some_rows), image) << "a pixel would have four thirds of a byte";
  image.width = 2;
  EXPECT_EQ(taken(image, "data", {.columns = {.begin = 1}}).data.size(), 8U) << "a pixel has two bytes";
}

/// Parts of parts. A range that keeps one index loses its step, so such parts are not compared.
class CutTwice : public CutGeometry {
 protected:
  struct Twice {
    Part first, second, both;
    bool is_comparable;
  };
  static bool is_comparable(const Range& first, const Range& second, const Range& both) {
    return both.step == first.step * second.step;
  }
  Twice twice(std::uint32_t rows, std::uint32_t columns) {
    Twice t{};
    t.first = {.rows = layouts.range_with_some(rows).canonical(),
               .columns = layouts.range_with_some(columns).canonical()};
    t.second = {.rows = layouts.range_with_some(t.first.rows.size_of(rows)).canonical(),
                .columns = layouts.range_with_some(t.first.columns.size_of(columns)).canonical()};
    t.both = {.rows = t.first.rows.then(t.second.rows), .columns = t.first.columns.then(t.second.columns)};
    t.is_comparable = is_comparable(t.first.rows, t.second.rows, t.both.rows) &&
                      is_comparable(t.first.columns, t.second.columns, t.both.columns);
    return t;
  }
};

TEST_F(CutTwice, CloudsAreThoseOfTheComposedRange) {
  for (int round = 0; round < rounds() / 2; ++round) {
    const PointCloud2 whole = layouts.cloud();
    Twice t = twice(whole.height, whole.width);
    const std::vector<std::string> channels = layouts.channels();
    const bool has_some = std::ranges::any_of(
        channels, [&](const std::string& name) { return readable_channel(whole, name) != nullptr; });
    if (has_some) t.first.channels = t.second.channels = t.both.channels = channels;
    if (t.both.is_whole()) continue;
    ASSERT_EQ(taken(taken(whole, "data", t.first), "data", t.second), taken(whole, "data", t.both))
        << "in round " << round;
  }
}

TEST_F(CutTwice, ImagesAreThoseOfTheComposedRange) {
  for (int round = 0; round < rounds() / 2; ++round) {
    const bool is_bayer = layouts.one_in(2);
    const Image whole = layouts.image(is_bayer ? "bayer_grbg8" : "rgb16");
    const Twice t = twice(whole.height, whole.width);
    const auto has_even_step = [](const Part& p) { return p.rows.step % 2 == 0 || p.columns.step % 2 == 0; };
    if (is_bayer && (has_even_step(t.first) || has_even_step(t.second))) continue;
    if (t.both.is_whole()) continue;
    ASSERT_EQ(taken(taken(whole, "data", t.first), "data", t.second), taken(whole, "data", t.both))
        << "in round " << round;
  }
}

TEST_F(CutTwice, GridsAreThoseOfTheComposedRange) {
  for (int round = 0; round < rounds() / 2; ++round) {
    const OccupancyGrid whole = layouts.grid();
    Twice t = twice(whole.info.height, whole.info.width);
    const bool is_even =
        t.first.rows.step == t.first.columns.step && t.second.rows.step == t.second.columns.step;
    if (!t.is_comparable || !is_even) continue;
    OccupancyGrid two = taken(taken(whole, "data", t.first), "data", t.second);
    const OccupancyGrid one = taken(whole, "data", t.both);
    const double size = double{whole.info.resolution} * (whole.info.height + whole.info.width);
    ASSERT_NEAR(two.info.resolution, one.info.resolution, 3e-7 * one.info.resolution);
    ASSERT_NEAR(two.info.origin.position.x, one.info.origin.position.x, 1e-10 + 2.4e-7 * size);
    ASSERT_NEAR(two.info.origin.position.y, one.info.origin.position.y, 1e-10 + 2.4e-7 * size);
    ASSERT_NEAR(two.info.origin.position.z, one.info.origin.position.z, 1e-10 + 2.4e-7 * size);
    two.info.resolution = one.info.resolution;
    two.info.origin.position = one.info.origin.position;
    ASSERT_EQ(two, one) << "in round " << round;
  }
}

TEST_F(CutTwice, ScansAreThoseOfTheComposedRange) {
  for (int round = 0; round < rounds() / 2; ++round) {
    LaserScan whole = layouts.scan();
    whole.intensities.clear();
    const Twice t = twice(1, static_cast<std::uint32_t>(whole.ranges.size()));
    if (!is_comparable(t.first.columns, t.second.columns, t.both.columns)) continue;
    const TypeSupport& type = type_support<LaserScan>();
    const FieldMask mask = type.full() - *type.find("intensities");
    const auto of = [&](const LaserScan& scan, const Part& part) {
      const auto leaf = static_cast<std::uint32_t>(*type.find("ranges").value().begin());
      const Selection wanted = Selection::make(mask, {{.leaf = leaf, .columns = part.columns}}, {}).value();
      return Cut<LaserScan>(scan, wanted).decoded();
    };
    LaserScan two = of(of(whole, t.first), t.second);
    const LaserScan one = of(whole, t.both);
    // Cutting in two steps rounds the least angle and the increment once more than cutting in one step.
    ASSERT_NEAR(two.angle_min, one.angle_min, 1.5 * two_ulp(whole));
    ASSERT_NEAR(two.angle_max, one.angle_max, 1.5 * two_ulp(whole));
    ASSERT_FLOAT_EQ(two.angle_increment, one.angle_increment);
    ASSERT_FLOAT_EQ(two.time_increment, one.time_increment);
    two.angle_min = one.angle_min;
    two.angle_max = one.angle_max;
    two.angle_increment = one.angle_increment;
    two.time_increment = one.time_increment;
    ASSERT_EQ(two, one) << "in round " << round;
  }
}

TEST_F(CutGeometry, PartsBehindTheEdgeAreEmpty) {
  const Range behind{.begin = 1'000'000}, far{.begin = Range::no_end - 1};
  for (const Range& range : {behind, far, Range{.begin = 0, .end = 0}}) {
    const PointCloud2 cloud = taken(layouts.cloud(), "data", {.columns = range, .channels = {"x", "y"}});
    EXPECT_TRUE(cloud.data.empty());
    EXPECT_EQ(std::uint64_t{cloud.height} * cloud.width, 0U);
    const Image image = taken(layouts.image("rgb8"), "data", {.rows = range});
    EXPECT_TRUE(image.data.empty());
    EXPECT_EQ(std::uint64_t{image.height} * image.width, 0U);
    const OccupancyGrid grid = taken(layouts.grid(), "data", {.rows = range});
    EXPECT_TRUE(grid.data.empty());
    EXPECT_EQ(std::uint64_t{grid.info.height} * grid.info.width, 0U);
    const LaserScan scan = layouts.scan();
    const Selection ranges =
        Selection::make(FieldMask(LaserScan::Field::header), {{.leaf = 10, .columns = range}}, {}).value();
    EXPECT_TRUE(Cut<LaserScan>(scan, ranges).decoded().ranges.empty());
  }
}

TEST_F(CutGeometry, WindowsAreCutAtTheEdge) {
  const Part wide{.rows = {.begin = 0, .end = 1'000'000}, .columns = {.begin = 0, .end = 1'000'000}};
  const PointCloud2 cloud = layouts.cloud();
  const PointCloud2 all_of_it = taken(cloud, "data", wide);
  EXPECT_EQ(all_of_it.height, cloud.height);
  EXPECT_EQ(all_of_it.width, cloud.width);
  EXPECT_EQ(all_of_it.data.size(), std::size_t{cloud.height} * cloud.width * cloud.point_step);
  const Image image = layouts.image("rgb8");
  EXPECT_EQ(taken(image, "data", wide).data.size(), std::size_t{image.height} * image.width * 3);
  OccupancyGrid grid = layouts.grid();
  grid.data.resize(std::size_t{grid.info.height} * grid.info.width);
  EXPECT_EQ(taken(grid, "data", wide), grid);
}

}  // namespace
}  // namespace sft
