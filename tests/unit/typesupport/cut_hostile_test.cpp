// Parts of messages whose headers contradict themselves or the data. Whatever the header says, the part is a
// consistent message, and cutting takes no more time than the message's bytes justify.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <ctime>
#include <limits>
#include <nav_msgs/msg/OccupancyGrid.hpp>
#include <sensor_msgs/msg/Image.hpp>
#include <sensor_msgs/msg/LaserScan.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <string>
#include <string_view>

#include "tests/support/cut.h"
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
using test::all_with;
using test::Cut;
using ::testing::AssertionFailure;
using ::testing::AssertionResult;
using ::testing::AssertionSuccess;

constexpr std::uint32_t most = std::numeric_limits<std::uint32_t>::max();

class CutHostile : public test::RandomTest {
 protected:
  using Part = Selection::Part;
  using Range = Selection::Range;

  static int rounds() { return static_cast<int>(test::test_rounds(SFT_TEST_ROUNDS)); }

  void TearDown() override {
    const double seconds = static_cast<double>(std::clock() - begin_) / CLOCKS_PER_SEC;
    EXPECT_LT(seconds, 60);
  }

  /// Cuts the selected part out of the message and returns it decoded. The test fails if the part is refused,
  /// if it is not a valid message, or if cutting takes a second or longer.
  template <class T>
  static T taken(const T& message, const Selection& selection) {
    const std::clock_t begin = std::clock();
    const Cut<T> cut(message, selection);
    EXPECT_LT(std::clock() - begin, CLOCKS_PER_SEC);
    EXPECT_TRUE(cut.ok());
    return cut.ok() ? cut.decoded() : T{};
  }
  template <class T>
  static T taken(const T& message, std::string_view text) {
    return taken(message, all_with<T>(text));
  }

  std::uint32_t extreme() {
    constexpr std::array<std::uint32_t, 12> values{
        0, 1, 2, 3, 7, 16, 255, 65536, 1U << 31, (1U << 31) + 1, most - 1, most};
    return values[layouts.below(values.size())];
  }
  /// Replaces the number by a neighbouring or an extreme number, or leaves it unchanged.
  void distort(std::uint32_t& number) {
    if (layouts.one_in(2)) return;
    number = layouts.one_in(2) ? extreme() : number + layouts.below(5) - 2;
  }
  Range extreme_range() {
    if (layouts.one_in(3)) return layouts.range(10);
    Range range{.begin = layouts.one_in(2) ? 0 : extreme(), .step = std::max(extreme(), 1U)};
    if (range.begin == most) --range.begin;
    range.end = std::max(extreme(), range.begin);
    return range;
  }
  template <class T>
  Selection extreme_selection(std::string_view path, std::vector<std::string> channels = {}) {
    const TypeSupport& type = type_support<T>();
    const auto leaf = static_cast<std::uint32_t>(*type.find(path).value().begin());
    return Selection::make(
               type.full(),
               {{.leaf = leaf, .rows = extreme_range(), .columns = extreme_range(), .channels = channels}},
               {})
        .value();
  }

  test::RandomLayouts layouts{random};

 private:
  std::clock_t begin_ = std::clock();
};

PointField field_of(std::string_view name, std::uint32_t offset, std::uint8_t datatype, std::uint32_t count) {
  PointField field;
  field.name = name;
  field.offset = offset;
  field.datatype = datatype;
  field.count = count;
  return field;
}

/// Makes the data longer than the cells. If the data had exactly the size of the cells, the length of rows
/// would be ignored.
void pad(std::vector<std::uint8_t>& data) { data.push_back(0); }

/// Returns a cloud of 2 rows of 3 points with x, y and z, without padding.
PointCloud2 honest_cloud() {
  PointCloud2 cloud;
  cloud.header.frame_id = "lidar";
  cloud.height = 2;
  cloud.width = 3;
  cloud.point_step = 16;
  cloud.row_step = 48;
  for (std::uint8_t i = 0; i < 96; ++i) cloud.data.push_back(i);
  cloud.fields = {field_of("x", 0, 7, 1), field_of("y", 4, 7, 1), field_of("z", 8, 7, 1)};
  return cloud;
}

AssertionResult has_no_points(const PointCloud2& cloud) {
  if (cloud.height == 0 && cloud.width == 0 && cloud.row_step == 0 && cloud.data.empty())
    return AssertionSuccess();
  return AssertionFailure() << cloud.height << " x " << cloud.width << " points, rows of " << cloud.row_step
                            << " bytes, " << cloud.data.size() << " bytes";
}

/// Checks the rules for each part of a cloud: rows have room for their points, and the data is as long as the
/// rows.
AssertionResult is_true(const PointCloud2& cloud) {
  const std::uint64_t row = std::uint64_t{cloud.width} * cloud.point_step;
  if (cloud.height > 0 && row > cloud.row_step) return AssertionFailure() << "a row is too short";
  if (std::uint64_t{cloud.height} * cloud.row_step != cloud.data.size())
    return AssertionFailure() << cloud.data.size() << " bytes for " << cloud.height << " rows of "
                              << cloud.row_step;
  return AssertionSuccess();
}

AssertionResult describes_its_channels(const PointCloud2& cloud) {
  std::uint64_t end = 0;
  constexpr std::array<std::uint64_t, 9> bytes{0, 1, 1, 2, 2, 4, 4, 4, 8};
  for (const PointField& field : cloud.fields) {
    if (field.datatype == 0 || field.datatype >= bytes.size()) return AssertionFailure() << "no type";
    if (field.count == 0) return AssertionFailure() << "no elements";
    if (field.offset != end) return AssertionFailure() << field.offset << " instead of " << end;
    end += bytes[field.datatype] * field.count;
  }
  return end == cloud.point_step ? AssertionSuccess() : AssertionFailure() << "they end at " << end;
}

TEST_F(CutHostile, CloudsThatContradictThemselvesGiveNoPoints) {
  const auto expect_none = [](const char* what, auto change) {
    PointCloud2 cloud = honest_cloud();
    change(cloud);
    for (const char* text : {"data[::2]", "data[rows 1:]", "data{x,z}", "data{y}[rows :1, columns 1:]"}) {
      const PointCloud2 some = taken(cloud, text);
      EXPECT_TRUE(has_no_points(some)) << what << ", " << text;
      EXPECT_EQ(some.header, cloud.header) << what;
      EXPECT_EQ(some.is_dense, cloud.is_dense) << what;
    }
  };
  expect_none("points of 0 bytes", [](auto& c) { c.point_step = 0; });
  expect_none("rows of 0 bytes", [](auto& c) { pad(c.data), c.row_step = 0; });
  expect_none("a row that is a byte too short", [](auto& c) { pad(c.data), c.row_step = 47; });
  expect_none("a row of one point less", [](auto& c) { pad(c.data), c.row_step = 32; });
  expect_none("a width that is too large", [](auto& c) { c.width = 4; });
  expect_none("a point that is too large", [](auto& c) { c.point_step = 17; });
  expect_none("a row too much", [](auto& c) { c.height = 3; });
  expect_none("a row that is too long", [](auto& c) { pad(c.data), c.row_step = 97; });
  expect_none("no data", [](auto& c) { c.data.clear(); });
  expect_none("half of the data", [](auto& c) { c.data.resize(40); });
  expect_none("a byte too little", [](auto& c) { c.data.pop_back(); });
  expect_none("as many rows as a number holds", [](auto& c) { c.height = most; });
  expect_none("as many columns as a number holds", [](auto& c) { c.width = most; });
  expect_none("the largest point", [](auto& c) { c.point_step = most; });
  expect_none("the largest row", [](auto& c) { pad(c.data), c.row_step = most; });
  expect_none("all that a number holds",
              [](auto& c) { c.height = c.width = c.point_step = c.row_step = most; });
  expect_none("a product that is 0 in 32 bits", [](auto& c) { c.height = c.row_step = 1U << 16; });
  expect_none("a row of which the bytes are 0 in 32 bits",
              [](auto& c) { c.width = c.point_step = 1U << 16; });
  expect_none("a product that is small in 32 bits", [](auto& c) {
    c.height = (1U << 28) + 2;
    c.row_step = 48;
  });
}

TEST_F(CutHostile, CloudsWithoutPointsGiveNone) {
  PointCloud2 cloud = honest_cloud();
  cloud.data.clear();
  for (const auto& [height, width, row] : std::vector<std::array<std::uint32_t, 3>>{
           {1, 0, 0}, {0, 3, 48}, {0, 0, 0}, {most, 0, 0}, {0, most, most}, {0, most, 0}}) {
    cloud.height = height;
    cloud.width = width;
    cloud.row_step = row;
    for (const char* text : {"data[::2]", "data{x,z}", "data[rows 1:]"}) {
      const PointCloud2 some = taken(cloud, text);
      EXPECT_TRUE(some.data.empty());
      EXPECT_EQ(std::uint64_t{some.height} * some.width, 0U) << height << " x " << width;
    }
  }
}

TEST_F(CutHostile, ChannelsThatCannotBeReadAreMissing) {
  const std::vector<PointField> unreadable{
      field_of("x", 0, 0, 1),        field_of("x", 0, 9, 1),        field_of("x", 0, 255, 1),
      field_of("x", 0, 7, 0),        field_of("x", 13, 7, 1),       field_of("x", 16, 2, 1),
      field_of("x", 0, 7, 5),        field_of("x", 0, 7, most),     field_of("x", 0, 8, 1U << 29),
      field_of("x", most, 7, 1),     field_of("x", most - 3, 7, 1), field_of("x", most, 8, most),
      field_of("x", 0, 8, 1U << 31), field_of("x", 1U << 31, 8, 1), field_of("X", 0, 7, 1),
      field_of("xx", 0, 7, 1),       field_of("", 0, 7, 1)};
  for (const PointField& field : unreadable) {
    PointCloud2 cloud = honest_cloud();
    cloud.fields[0] = field;
    const PointCloud2 some = taken(cloud, "data{x,z}");
    ASSERT_EQ(some.fields.size(), 1U) << field.offset << " " << int{field.datatype} << " " << field.count;
    EXPECT_EQ(some.fields[0], field_of("z", 0, 7, 1));
    EXPECT_EQ(some.point_step, 4U);
    EXPECT_EQ(some.row_step, 12U);
    EXPECT_EQ(some.height, 2U);
    EXPECT_EQ(some.width, 3U);
    ASSERT_EQ(some.data.size(), 24U);
    EXPECT_EQ(some.data[0], 8);
    EXPECT_EQ(some.data[4], 24);
    EXPECT_EQ(some.data[23], 91);
  }
}

TEST_F(CutHostile, TheFirstOfSeveralChannelsWithANameCountsAlsoIfItIsUnreadable) {
  PointCloud2 cloud = honest_cloud();
  cloud.fields.insert(cloud.fields.begin(), field_of("x", 4, 9, 1));
  EXPECT_EQ(taken(cloud, "data{x,z}").fields, std::vector{field_of("z", 0, 7, 1)});
  cloud.fields[0].datatype = PointField::UINT16;
  EXPECT_EQ(taken(cloud, "data{x,z}").fields, (std::vector{field_of("x", 0, 4, 1), field_of("z", 2, 7, 1)}));
}

TEST_F(CutHostile, ManyFieldsAreSearchedAndNotKept) {
  for (const std::size_t count : {65U, 10'000U}) {
    PointCloud2 cloud = honest_cloud();
    const std::vector<PointField> wanted = cloud.fields;
    cloud.fields.clear();
    for (std::size_t i = 0; i + 3 < count; ++i)
      cloud.fields.push_back(
          field_of("channel " + std::to_string(i), static_cast<std::uint32_t>(i % 9), 7, 1));
    cloud.fields.insert(cloud.fields.end(), wanted.begin(), wanted.end());
    const PointCloud2 some = taken(cloud, "data{x,y,z}[rows 1, columns ::2]");
    EXPECT_EQ(some.fields, wanted);
    EXPECT_EQ(some.data.size(), 24U);
    EXPECT_EQ(taken(cloud, "data[::2]").fields, cloud.fields) << "a part without channels has all fields";
    cloud.fields.assign(count, wanted[0]);
    EXPECT_EQ(taken(cloud, "data{x,y,z}").fields, std::vector{wanted[0]});
  }
}

TEST_F(CutHostile, AsManyChannelsAsASelectionHoldsMayOverlapUpToTheSizeOfThePoint) {
  PointCloud2 cloud = honest_cloud();
  std::string text;
  cloud.fields.clear();
  cloud.point_step = 64U * 16;
  cloud.row_step = 3 * cloud.point_step;
  cloud.data.resize(2 * cloud.row_step);
  for (std::size_t i = 0; i < cloud.data.size(); ++i)
    cloud.data[i] = static_cast<std::uint8_t>(i / 1024 * 16 + i % 1024);
  for (std::size_t i = 0; i < Selection::channels_max; ++i) {
    const std::string name = "c" + std::to_string(i);
    cloud.fields.push_back(field_of(name, 0, 8, 2));
    text += (text.empty() ? "data{" : ",") + name;
  }
  text += "}";
  const PointCloud2 some = taken(cloud, text);
  EXPECT_EQ(some.point_step, 64U * 16);
  EXPECT_EQ(some.fields.size(), 64U);
  ASSERT_EQ(some.data.size(), 6U * 64 * 16);
  for (std::size_t i = 0; i < some.data.size(); ++i) ASSERT_EQ(some.data[i], i / 1024 * 16 + i % 16);

  --cloud.point_step;
  EXPECT_TRUE(has_no_points(taken(cloud, text))) << "the part would be larger than the field";
}

TEST_F(CutHostile, BytesOfBigEndianCloudsAreTakenAsTheyAre) {
  PointCloud2 cloud = honest_cloud();
  const PointCloud2 little = taken(cloud, "data{x,z}[::2]");
  cloud.is_bigendian = true;
  const PointCloud2 big = taken(cloud, "data{x,z}[::2]");
  EXPECT_TRUE(big.is_bigendian);
  EXPECT_EQ(big.data, little.data);
  EXPECT_EQ(big.fields, little.fields);
}

TEST_F(CutHostile, DistortedCloudsGivePartsThatTellTheTruth) {
  for (int round = 0; round < rounds(); ++round) {
    PointCloud2 cloud = layouts.cloud();
    distort(cloud.height);
    distort(cloud.width);
    distort(cloud.point_step);
    distort(cloud.row_step);
    for (PointField& field : cloud.fields) {
      distort(field.offset);
      distort(field.count);
    }
    if (layouts.one_in(3)) cloud.data.resize(layouts.below(cloud.data.size() + 1));
    const std::vector<std::string> channels =
        layouts.one_in(2) ? layouts.channels() : std::vector<std::string>{};
    const Selection selection = extreme_selection<PointCloud2>("data", channels);
    if (selection.is_mask()) continue;
    const PointCloud2 some = taken(cloud, selection);
    ASSERT_TRUE(is_true(some)) << "in round " << round;
    if (channels.empty()) {
      ASSERT_EQ(some.fields, cloud.fields);
      ASSERT_LE(some.data.size(), cloud.data.size());
    } else if (!some.data.empty()) {
      ASSERT_TRUE(describes_its_channels(some)) << "in round " << round;
    }
    ASSERT_EQ(some.header, cloud.header);
  }
}

Image honest_image(const std::string& encoding = "rgb8") {
  Image image;
  image.header.frame_id = "camera";
  image.height = 4;
  image.width = 5;
  image.encoding = encoding;
  image.step = 15;
  for (std::uint8_t i = 0; i < 60; ++i) image.data.push_back(i);
  return image;
}

TEST_F(CutHostile, ImagesThatContradictThemselvesGiveNoPixels) {
  const auto expect_none = [](const char* what, auto change) {
    Image image = honest_image();
    change(image);
    for (const char* text : {"data[::2]", "data[rows 1:]", "data[rows 3, columns 4]"}) {
      const Image some = taken(image, text);
      EXPECT_EQ(some.height, 0U) << what;
      EXPECT_EQ(some.width, 0U) << what;
      EXPECT_EQ(some.step, 0U) << what;
      EXPECT_TRUE(some.data.empty()) << what;
      EXPECT_EQ(some.header, image.header) << what;
    }
  };
  expect_none("rows of 0 bytes", [](auto& i) { pad(i.data), i.step = 0; });
  expect_none("a row that is a byte too short", [](auto& i) { pad(i.data), i.step = 14; });
  expect_none("a width that is too large", [](auto& i) { i.width = 6; });
  expect_none("a pixel that is too large", [](auto& i) { i.encoding = "rgba8"; });
  expect_none("a row too much", [](auto& i) { i.height = 5; });
  expect_none("a byte too little", [](auto& i) { i.data.pop_back(); });
  expect_none("no data", [](auto& i) { i.data.clear(); });
  expect_none("as many rows as a number holds", [](auto& i) { i.height = most; });
  expect_none("as many columns as a number holds", [](auto& i) { i.width = most; });
  expect_none("the largest row", [](auto& i) { pad(i.data), i.step = most; });
  expect_none("all that a number holds", [](auto& i) { i.height = i.width = i.step = most; });
  expect_none("a width of which the bytes are few in 32 bits", [](auto& i) { i.width = most / 3 + 1; });
  expect_none("rows of which the bytes are few in 32 bits", [](auto& i) { i.height = i.step = 1U << 16; });
}

TEST_F(CutHostile, StrangeEncodingsAreTakenAsTheirBytesOrLeftWhole) {
  const std::vector<std::string> encodings{"",
                                           "8UC",
                                           "8UC0",
                                           "64FC0",
                                           "8UC4294967295",
                                           "8UC-1",
                                           "64FC99999999999999999999",
                                           "bayer_",
                                           "bayer_rggb",
                                           "bayer_rggb32",
                                           "bayer_xxxx8",
                                           "16FC1",
                                           "RGB8",
                                           "rgb",
                                           "rgb8 ",
                                           "mono",
                                           std::string(10'000, 'C'),
                                           "8UC536870913"};
  for (const std::string& encoding : encodings) {
    for (const std::uint32_t step : {15U, 14U, 0U, most}) {
      Image image = honest_image(encoding);
      image.step = step;
      for (const char* text : {"data[1:3]", "data[rows ::2]", "data[rows 1, columns 1]"}) {
        const Image some = taken(image, text);
        if (some == image) continue;
        EXPECT_EQ(std::uint64_t{some.height} * some.step, some.data.size()) << encoding;
        EXPECT_LE(some.data.size(), image.data.size()) << encoding;
        EXPECT_TRUE(some.width <= 5 && some.height <= 4) << encoding;
        EXPECT_EQ(some.header, image.header) << encoding;
      }
    }
  }
}

TEST_F(CutHostile, DistortedImagesGivePartsThatTellTheTruth) {
  for (int round = 0; round < rounds(); ++round) {
    Image image = layouts.image();
    distort(image.height);
    distort(image.width);
    distort(image.step);
    if (layouts.one_in(3)) image.data.resize(layouts.below(image.data.size() + 1));
    const Selection selection = extreme_selection<Image>("data");
    if (selection.is_mask()) continue;
    const Image some = taken(image, selection);
    if (some == image) continue;
    ASSERT_EQ(std::uint64_t{some.height} * some.step, some.data.size()) << "in round " << round;
    ASSERT_TRUE(some.height == 0 || some.width <= some.step) << "in round " << round;
    ASSERT_LE(some.data.size(), image.data.size());
    ASSERT_EQ(some.header, image.header);
  }
}

TEST_F(CutHostile, GridsThatContradictThemselvesGiveNoCells) {
  for (const auto& [height, width] : std::vector<std::array<std::uint32_t, 2>>{
           {3, 4}, {11, 1}, {1, 11}, {most, 1}, {1, most}, {most, most}, {1U << 16, 1U << 16}}) {
    OccupancyGrid grid;
    grid.info.height = height;
    grid.info.width = width;
    grid.info.resolution = 0.5F;
    grid.info.origin.orientation.w = 1;
    grid.data.assign(10, 100);
    for (const char* text :
         {"data[rows 1:]", "data[1:]", "data[rows ::2, columns ::2]", "data[rows 2, columns 0]"}) {
      const OccupancyGrid some = taken(grid, text);
      EXPECT_EQ(some.info.height, 0U) << height << " x " << width << text;
      EXPECT_EQ(some.info.width, 0U) << height << " x " << width << text;
      EXPECT_TRUE(some.data.empty()) << height << " x " << width << text;
    }
  }
}

TEST_F(CutHostile, DistortedGridsGivePartsThatTellTheTruth) {
  const std::array<double, 6> numbers{0, -1, 1e308, -1e-308, std::nan(""), INFINITY};
  const auto number = [&] { return numbers[layouts.below(numbers.size())]; };
  for (int round = 0; round < rounds() / 2; ++round) {
    OccupancyGrid grid = layouts.grid();
    distort(grid.info.height);
    distort(grid.info.width);
    auto& [position, q] = grid.info.origin;
    if (layouts.one_in(3)) grid.info.resolution = static_cast<float>(number() == 0 ? 0 : NAN);
    if (layouts.one_in(3)) position.x = number();
    if (layouts.one_in(3)) q.w = number();
    if (layouts.one_in(9)) q.x = q.y = q.z = q.w = 0;
    if (layouts.one_in(3)) grid.data.resize(layouts.below(grid.data.size() + 1));
    const Selection selection = extreme_selection<OccupancyGrid>("data");
    const Part* part = selection.part(*type_support<OccupancyGrid>().find("data").value().begin());
    if (part == nullptr) continue;
    const OccupancyGrid some = taken(grid, selection);
    ASSERT_LE(some.data.size(), grid.data.size());
    if (part->rows.step == part->columns.step) {
      ASSERT_EQ(some.data.size(), std::uint64_t{some.info.height} * some.info.width) << "in round " << round;
    }
    ASSERT_EQ(some.header, grid.header);
  }
}

TEST_F(CutHostile, ScansWithAnglesThatAreNoNumbersKeepTheirRanges) {
  for (const float strange : {NAN, INFINITY, -INFINITY, 0.0F, 3e38F}) {
    LaserScan scan;
    scan.angle_min = scan.angle_increment = scan.time_increment = strange;
    scan.ranges = {0, 1, 2, 3, 4};
    scan.intensities = {10, 11};
    const LaserScan some = taken(scan, "ranges[1::2], intensities[1::2]");
    EXPECT_EQ(some.ranges, (std::vector<float>{1, 3}));
    EXPECT_EQ(some.intensities, (std::vector<float>{11}));
    EXPECT_TRUE(taken(scan, "ranges[4294967294:], intensities[4294967294:]").ranges.empty());
    EXPECT_EQ(taken(scan, "ranges[::4294967294], intensities[::4294967294]").ranges, (std::vector<float>{0}));
  }
}

TEST_F(CutHostile, ListsOfTwoLengthsAreEachCutAtTheirOwnEdge) {
  for (int round = 0; round < rounds() / 2; ++round) {
    LaserScan scan = layouts.scan();
    scan.intensities.resize(layouts.below(scan.ranges.size() * 2), 7);
    const Range range = extreme_range().canonical();
    if (range.is_all()) continue;
    const auto leaf = static_cast<std::uint32_t>(*type_support<LaserScan>().find("ranges").value().begin());
    const LaserScan some = taken(
        scan, Selection::make(type_support<LaserScan>().full(),
                              {{.leaf = leaf, .columns = range}, {.leaf = leaf + 1, .columns = range}}, {})
                  .value());
    ASSERT_EQ(some.ranges.size(), range.size_of(static_cast<std::uint32_t>(scan.ranges.size())));
    ASSERT_EQ(some.intensities.size(), range.size_of(static_cast<std::uint32_t>(scan.intensities.size())));
    for (std::size_t i = 0; i < some.ranges.size(); ++i)
      ASSERT_EQ(some.ranges[i], scan.ranges[range.begin + i * range.step]);
  }
}

TEST_F(CutHostile, LengthsThatLeadOutsideTheBodyAreRefused) {
  const TypeSupport& type = type_support<PointCloud2>();
  const detail::ProjectionPlan plan(type, type.closed(all_with<PointCloud2>("data{x}[::2]")));
  detail::Projection projection;
  for (const std::size_t slot : {2U, 5U, 9U}) {  // the slots of frame_id, fields and data
    for (const std::uint32_t length : {1'000U, 1'000'000U, most}) {
      test::Encoded changed(honest_cloud());
      std::memcpy(changed.body() + changed.index()[slot], &length, sizeof length);
      EXPECT_FALSE(projection.project(changed.state(), plan)) << slot << " " << length;
    }
  }
  EXPECT_TRUE(projection.project(test::Encoded(honest_cloud()).state(), plan));
}

TEST_F(CutHostile, SamplesWithAnyBitsGiveMessagesOrAreRefused) {
  const TypeSupport& type = type_support<PointCloud2>();
  for (int round = 0; round < rounds(); ++round) {
    const test::Encoded honest(layouts.cloud());
    const Selection selection = extreme_selection<PointCloud2>("data", layouts.channels());
    const detail::ProjectionPlan plan(type, type.closed(selection));
    detail::Projection projection;
    std::vector<std::byte> body = honest.bytes();
    const std::size_t header = std::min<std::size_t>(body.size(), 200);
    for (std::uint32_t left = 1 + layouts.below(4); left > 0; --left)
      body[layouts.below(header)] ^= static_cast<std::byte>(1U << layouts.below(8));
    detail::SampleState state = honest.state();
    state.body = body.data();
    // The index is that of the unchanged body.
    if (projection.project(state, plan)) test::gathered(projection);

    std::vector<std::uint32_t> index(honest.slots());
    if (detail::build_index(state, type.type(), index) != detail::WalkStatus::ok) continue;
    state.index = index.data();
    ASSERT_TRUE(projection.project(state, plan)) << "in round " << round;
    test::decoded_from<PointCloud2>(test::gathered(projection), plan.mask());
  }
}

}  // namespace
}  // namespace sft
