// A projection of a part equals, byte by byte, the encoding of the message that the reference cuts. The tests
// use random messages with layouts, lists without a layout, random parts and random other fields.
#include <gtest/gtest.h>

#include <nav_msgs/msg/Odometry.hpp>
#include <proof.hpp>
#include <sensor_msgs/msg/BatteryState.hpp>
#include <sensor_msgs/msg/JointState.hpp>
#include <stereo_msgs/msg/DisparityImage.hpp>
#include <string>

#include "tests/unit/typesupport/cut_law.h"

#ifndef SFT_TEST_ROUNDS
#define SFT_TEST_ROUNDS 1000
#endif

namespace sft {
namespace {

class CutLaw : public CutLawTest {
 protected:
  static int rounds() { return static_cast<int>(test::test_rounds(SFT_TEST_ROUNDS)); }
};

TEST_F(CutLaw, PointsAreThoseThatTheReferenceCuts) {
  for (int round = 0; round < rounds() && !HasFatalFailure(); ++round) {
    SCOPED_TRACE("round " + std::to_string(round));
    const PointCloud2 cloud = layouts.cloud();
    expect_points(cloud, part_of_cloud(cloud));
  }
}

TEST_F(CutLaw, PixelsAreThoseThatTheReferenceCuts) {
  for (int round = 0; round < rounds() && !HasFatalFailure(); ++round) {
    SCOPED_TRACE("round " + std::to_string(round));
    expect_pixels(layouts.image());
  }
}

TEST_F(CutLaw, CellsAreThoseThatTheReferenceCuts) {
  for (int round = 0; round < rounds() && !HasFatalFailure(); ++round) {
    SCOPED_TRACE("round " + std::to_string(round));
    expect_cells(layouts.grid());
  }
}

TEST_F(CutLaw, BeamsAreThoseThatTheReferenceCuts) {
  for (int round = 0; round < rounds() && !HasFatalFailure(); ++round) {
    SCOPED_TRACE("round " + std::to_string(round));
    expect_beams(layouts.scan());
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
  /// Checks ranges of the list at `path`. `list` returns the list of a message.
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
  /// Expects the closed selection to have exactly the fields in `fields` and the parts in `text`.
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
