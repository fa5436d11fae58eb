// What a projection takes of a message is, byte by byte, the encoding of the message that the reference cuts:
// for random messages with layouts, lists without one, random parts and random other fields.
#include <gtest/gtest.h>

#include <cmath>
#include <nav_msgs/msg/OccupancyGrid.hpp>
#include <nav_msgs/msg/Odometry.hpp>
#include <proof.hpp>
#include <sensor_msgs/msg/BatteryState.hpp>
#include <sensor_msgs/msg/Image.hpp>
#include <sensor_msgs/msg/JointState.hpp>
#include <sensor_msgs/msg/LaserScan.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <stereo_msgs/msg/DisparityImage.hpp>
#include <string>
#include <string_view>

#include "tests/support/cut.h"
#include "tests/support/cut_reference.h"
#include "tests/support/random_layouts.h"
#include "tests/support/random_value.h"

#ifndef SFT_TEST_ROUNDS
#define SFT_TEST_ROUNDS 1000
#endif

namespace sft {
namespace {

using nav_msgs::msg::OccupancyGrid;
using sensor_msgs::msg::Image;
using sensor_msgs::msg::LaserScan;
using sensor_msgs::msg::PointCloud2;
using test::Cut;
using test::is_encoded;
namespace cut_reference = test::cut_reference;

class CutLaw : public test::RandomTest {
 protected:
  using Part = Selection::Part;
  using Range = Selection::Range;

  static int rounds() { return static_cast<int>(test::test_rounds(SFT_TEST_ROUNDS)); }

  template <class T>
  static std::uint32_t leaf(std::string_view path) {
    return static_cast<std::uint32_t>(*type_support<T>().find(path).value().begin());
  }

  /// The part, and any other fields.
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

  test::RandomLayouts layouts{random};
  test::RandomValues values{random};
};

/// A part without any bytes has as many rows and columns as the ranges have, or none at all.
void settle(const PointCloud2& taken, PointCloud2& expected) {
  if (!expected.data.empty()) return;
  if (expected.height == 0 && taken.row_step == 0) expected.row_step = 0;
  if (taken.height == 0 && taken.width == 0) expected.height = expected.width = expected.row_step = 0;
}

/// A pattern without pixels begins anywhere.
void settle(const Image& taken, Image& expected) {
  if (!expected.data.empty()) return;
  if (expected.height == 0 && taken.step == 0) expected.step = 0;
  if (taken.height == 0 && taken.width == 0) expected.height = expected.width = expected.step = 0;
  if (expected.encoding.starts_with("bayer_")) {
    EXPECT_TRUE(cut_reference::bytes_of_encoding(taken.encoding)) << taken.encoding;
    expected.encoding = taken.encoding;
  }
}

/// Turning has several formulas, which round differently. A grid without cells may be anywhere.
void settle(const OccupancyGrid& taken, OccupancyGrid& expected) {
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

TEST_F(CutLaw, PointsAreThoseThatTheReferenceCuts) {
  for (int round = 0; round < rounds(); ++round) {
    const PointCloud2 cloud = layouts.cloud();
    const Selection selection = with_other_fields<PointCloud2>({part_of_cloud(cloud)});
    const Part* part = selection.part(leaf<PointCloud2>("data"));
    PointCloud2 expected = part == nullptr ? cloud : cut_reference::cut(cloud, *part);
    const Cut<PointCloud2> cut(cloud, selection);
    settle(cut.decoded(cloud), expected);
    ASSERT_TRUE(is_encoded(expected, cut)) << "in round " << round << " of " << words<PointCloud2>(selection);
  }
}

/// False where two rules of the specification could both hold: a part that is empty, of an image that would
/// stay whole, and a step of which only the first index is within the image.
bool is_settled(const Image& image, const Selection::Part& part) {
  const std::uint32_t rows = part.rows.size_of(image.height), columns = part.columns.size_of(image.width);
  const bool is_named = cut_reference::bytes_of_encoding(image.encoding).has_value();
  if (is_named && !image.encoding.starts_with("bayer_") && !image.encoding.ends_with("uyvy") &&
      !image.encoding.starts_with("yu"))
    return true;
  if (rows == 0 || columns == 0) return false;
  return (rows > 1 || part.rows.step == 1) && (columns > 1 || part.columns.step == 1);
}

TEST_F(CutLaw, PixelsAreThoseThatTheReferenceCuts) {
  for (int round = 0; round < rounds(); ++round) {
    const Image image = layouts.image();
    const Selection selection = with_other_fields<Image>({{.leaf = leaf<Image>("data"),
                                                           .rows = layouts.range(image.height),
                                                           .columns = layouts.range(image.width)}});
    const Part* part = selection.part(leaf<Image>("data"));
    if (part != nullptr && !is_settled(image, *part)) continue;
    Image expected = part == nullptr ? image : cut_reference::cut(image, *part);
    const Cut<Image> cut(image, selection);
    settle(cut.decoded(image), expected);
    ASSERT_TRUE(is_encoded(expected, cut))
        << "in round " << round << " of " << words<Image>(selection) << " and an image of " << image.height
        << " x " << image.width << " pixels '" << image.encoding << "'";
  }
}

TEST_F(CutLaw, CellsAreThoseThatTheReferenceCuts) {
  for (int round = 0; round < rounds(); ++round) {
    const OccupancyGrid grid = layouts.grid();
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
      if (is_empty) continue;  // both empty and whole would be right
    }
    const Cut<OccupancyGrid> cut(grid, selection);
    if (part != nullptr) settle(cut.decoded(grid), expected);
    ASSERT_TRUE(is_encoded(expected, cut))
        << "in round " << round << " of " << words<OccupancyGrid>(selection);
  }
}

TEST_F(CutLaw, BeamsAreThoseThatTheReferenceCuts) {
  for (int round = 0; round < rounds(); ++round) {
    const LaserScan scan = layouts.scan();
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
    ASSERT_TRUE(is_encoded(expected, cut))
        << "in round " << round << " of " << words<LaserScan>(selection) << " and " << beams << " beams";
  }
}

TEST_F(CutLaw, LayoutsHoldWhereTheirTypesAreMembersOfOthers) {
  using stereo_msgs::msg::DisparityImage;
  for (int round = 0; round < rounds(); ++round) {
    DisparityImage message;
    values.fill(type_support<DisparityImage>().type(), &message);
    message.image = layouts.image("32FC1");
    const Selection selection =
        with_other_fields<DisparityImage>({{.leaf = leaf<DisparityImage>("image.data"),
                                            .rows = layouts.range_with_some(message.image.height),
                                            .columns = layouts.range_with_some(message.image.width)}});
    DisparityImage expected = message;
    if (const Part* part = selection.part(leaf<DisparityImage>("image.data")))
      expected.image = cut_reference::cut(message.image, *part);
    const Cut<DisparityImage> cut(message, selection);
    ASSERT_TRUE(is_encoded(expected, cut))
        << "in round " << round << " of " << words<DisparityImage>(selection);
  }
}

class CutListLaw : public CutLaw {
 protected:
  /// For the list at `path`, which list(message) refers to.
  template <class T, class List>
  void expect_elements_of_its_range(const char* path, List list) {
    for (int round = 0; round < rounds() / 4; ++round) {
      T message;
      values.fill(type_support<T>().type(), &message);
      const auto count = static_cast<std::uint32_t>(list(message).size());
      const Selection selection =
          with_other_fields<T>({{.leaf = leaf<T>(path), .columns = layouts.range(count)}});
      T expected = message;
      if (const Part* part = selection.part(leaf<T>(path)))
        list(expected) = cut_reference::cut(list(message), part->columns);
      ASSERT_TRUE(is_encoded(expected, Cut<T>(message, selection)))
          << "in round " << round << " of " << words<T>(selection) << " and " << count << " elements";
    }
  }
};

TEST_F(CutListLaw, ListsOfNumbersHaveTheElementsOfTheirRange) {
  using sensor_msgs::msg::BatteryState;
  expect_elements_of_its_range<BatteryState>(
      "cell_voltage", [](auto& m) -> auto& { return m.cell_voltage; });
  expect_elements_of_its_range<BatteryState>(
      "cell_temperature", [](auto& m) -> auto& { return m.cell_temperature; });
  expect_elements_of_its_range<sensor_msgs::msg::JointState>(
      "velocity", [](auto& m) -> auto& { return m.velocity; });
  expect_elements_of_its_range<proof::Misaligned>(
      "doubles", [](auto& m) -> auto& { return m.doubles; });
}

TEST_F(CutListLaw, ListsOfTextsHaveTheElementsOfTheirRange) {
  expect_elements_of_its_range<sensor_msgs::msg::JointState>(
      "name", [](auto& m) -> auto& { return m.name; });
  expect_elements_of_its_range<proof::Track>(
      "tags", [](auto& m) -> auto& { return m.tags; });
}

TEST_F(CutListLaw, ListsInMembersHaveTheElementsOfTheirRange) {
  expect_elements_of_its_range<proof::Scene>(
      "best.tags", [](auto& m) -> auto& { return m.best.tags; });
}

TEST_F(CutListLaw, BoundedListsHaveTheElementsOfTheirRange) {
  expect_elements_of_its_range<proof::Bounded>(
      "doubles", [](auto& m) -> auto& { return m.doubles; });
  expect_elements_of_its_range<proof::Bounded>(
      "tags", [](auto& m) -> auto& { return m.tags; });
}

TEST_F(CutListLaw, PartsOfSeveralListsAreTakenAtOnce) {
  using sensor_msgs::msg::JointState;
  JointState state;
  state.name = {"a", "bcd", "", "efghij", "k"};
  state.position = {1, 2, 3, 4, 5};
  state.velocity = {6, 7, 8, 9, 10};
  state.effort = {11, 12};
  JointState expected = state;
  expected.name = {"bcd", "efghij"};
  expected.position = {1, 2};
  expected.velocity = {};
  const Selection selection = parsed<JointState>("name[1::2], position[:2], velocity[9:], effort");
  EXPECT_TRUE(is_encoded(expected, Cut<JointState>(state, selection)));
}

TEST_F(CutListLaw, ArraysAreAlwaysWhole) {
  using nav_msgs::msg::Odometry;
  Odometry odometry;
  values.fill(type_support<Odometry>().type(), &odometry);
  const Part some{.leaf = leaf<Odometry>("pose.covariance"), .columns = {.step = 7}};
  const Part none{.leaf = leaf<Odometry>("twist.covariance"), .columns = {.end = 0}};
  for (const std::vector<Part>& parts : {std::vector{some}, {none}, {some, none}}) {
    const Selection selection = Selection::make(FieldMask(Odometry::Field::header), parts, {}).value();
    EXPECT_TRUE(is_encoded(odometry, Cut<Odometry>(odometry, selection)));
  }
  EXPECT_FALSE(type_support<Odometry>().parse_selection("pose.covariance[::7]"));
}

class CutNeeds : public CutLaw {
 protected:
  /// The closed selection has just the fields that `fields` names, and what is sent with them.
  template <class T>
  static void expect_needs(std::string_view text, std::string_view fields) {
    const TypeSupport& type = type_support<T>();
    const Selection closed = type.closed(parsed<T>(text));
    EXPECT_EQ(type.closed(closed), closed) << text << ", closed again";
    EXPECT_EQ(type.closed(closed.mask()), closed.mask()) << text << ", of which the mask is closed";
    EXPECT_EQ(type.format_mask(closed.mask()),
              type.format_mask(type.closed(type.parse_mask(fields).value())));
  }
};

TEST_F(CutNeeds, AreTheFieldsThatALayoutReadsOrRewrites) {
  const std::string_view cloud = "height, width, fields, is_bigendian, point_step, row_step, data";
  expect_needs<PointCloud2>("data[::2]", cloud);
  expect_needs<PointCloud2>("data{x}", cloud);
  expect_needs<PointCloud2>("fields[].name, data[rows 1:]", cloud);
  expect_needs<Image>("data[rows 1:]", "height, width, encoding, is_bigendian, step, data");
  const std::string scan = "angle_min, angle_max, angle_increment, time_increment, ";
  expect_needs<LaserScan>("ranges[::4]", scan + "ranges");
  expect_needs<LaserScan>("intensities[7]", scan + "intensities");
  expect_needs<OccupancyGrid>("data[rows ::2, columns ::2]",
                              "info.resolution, info.width, info.height, info.origin, data");
  expect_needs<stereo_msgs::msg::DisparityImage>(
      "image.data[:5], f",
      "image.height, image.width, image.encoding, image.is_bigendian, image.step, image.data, f");
}

TEST_F(CutNeeds, AreNothingElseWhereThereIsNoLayoutOrNoPart) {
  expect_needs<sensor_msgs::msg::JointState>("name[::2]", "name");
  expect_needs<LaserScan>("ranges", "ranges");
  expect_needs<PointCloud2>("data, fields[].name", "data, fields[].name");
  const Selection whole = parsed<PointCloud2>("data, fields[].name");
  EXPECT_TRUE(type_support<PointCloud2>().closed(whole).is_mask());
}

TEST_F(CutNeeds, OfAScanIsOnePartForBothLists) {
  const auto closed = [](std::string_view text) {
    const Selection selection = type_support<LaserScan>().closed(parsed<LaserScan>(text));
    const Part* ranges = selection.part(cut_reference::ranges_leaf);
    const Part* intensities = selection.part(cut_reference::intensities_leaf);
    EXPECT_EQ(ranges == nullptr, intensities == nullptr) << text;
    if (ranges != nullptr && intensities != nullptr) {
      EXPECT_EQ(ranges->columns, intensities->columns) << text;
    }
    return ranges != nullptr;
  };
  EXPECT_TRUE(closed("ranges[::4], intensities[::4]"));
  EXPECT_FALSE(closed("ranges[::4], intensities[::2]"));
  EXPECT_FALSE(closed("ranges[::4], intensities"));
  EXPECT_FALSE(closed("ranges, intensities[:9]"));
}

TEST_F(CutNeeds, AreAllThatTheSourceHasToHave) {
  for (int round = 0; round < rounds() / 4; ++round) {
    const PointCloud2 cloud = layouts.cloud();
    const Selection selection = with_other_fields<PointCloud2>({part_of_cloud(cloud)});
    const Cut<PointCloud2> of_all(cloud, selection);
    const Cut<PointCloud2> of_needs(cloud, selection, of_all.mask());
    ASSERT_TRUE(of_needs.ok());
    ASSERT_TRUE(of_needs.bytes() == of_all.bytes()) << words<PointCloud2>(selection);
  }
}

TEST_F(CutNeeds, AreMissedWhereTheSourceLacksOne) {
  const PointCloud2 cloud = layouts.cloud();
  const TypeSupport& type = type_support<PointCloud2>();
  const Selection selection = parsed<PointCloud2>("data{x}[::2]");
  for (const char* lacks : {"height", "width", "point_step", "row_step", "fields[].offset", "data"}) {
    FieldMask has = type.full();
    has.erase(leaf<PointCloud2>(lacks));
    EXPECT_FALSE(Cut<PointCloud2>(cloud, selection, has).ok()) << lacks;
  }
}

TEST_F(CutLaw, SelectionsWithoutPartsAreProjectedAsMasks) {
  for (int round = 0; round < rounds() / 4; ++round) {
    const PointCloud2 cloud = layouts.cloud();
    const Selection selection(values.mask(type_support<PointCloud2>().leaves()));
    const Cut<PointCloud2> cut(cloud, selection);
    ASSERT_EQ(cut.mask(), type_support<PointCloud2>().closed(selection.mask()));
    ASSERT_TRUE(is_encoded(cloud, cut)) << words<PointCloud2>(selection);
  }
}

TEST_F(CutLaw, OnePlanServesMessagesOfAnySize) {
  const TypeSupport& type = type_support<PointCloud2>();
  const Selection selection = type.closed(parsed<PointCloud2>("header, data{x,y,z}[rows :7, columns ::2]"));
  const detail::ProjectionPlan plan(type, selection);
  const Part part = *selection.part(leaf<PointCloud2>("data"));
  detail::Projection projection;
  for (int round = 0; round < rounds() / 4; ++round) {
    const PointCloud2 cloud = layouts.cloud();
    PointCloud2 expected = cut_reference::cut(cloud, part);
    ASSERT_TRUE(projection.project(test::Encoded(cloud).state(), plan));
    settle(test::decoded_from<PointCloud2>(test::gathered(projection), plan.mask()), expected);
    ASSERT_TRUE(test::gathered(projection) == test::Encoded(type.type(), &expected, plan.mask()).bytes())
        << "in round " << round;
  }
}

}  // namespace
}  // namespace sft
