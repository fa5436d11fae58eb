// Parts of parts of clouds and scans. A slice of a slice equals, byte by byte, the slice that both selections
// combined take, even if both steps take channels, rows and columns.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <sensor_msgs/msg/LaserScan.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/cut_reference.h"
#include "tests/unit/typesupport/part_of_part.h"

namespace sft {
namespace {

using sensor_msgs::msg::LaserScan;
using sensor_msgs::msg::PointCloud2;
using sensor_msgs::msg::PointField;

class CloudsOfClouds : public PartOfPartTest {
 protected:
  Part any_part_of_cloud(std::uint32_t rows, std::uint32_t columns) {
    Part part = any_part(rows, columns);
    if (!layouts.one_in(3)) part.channels = layouts.channels();
    return part;
  }
  Steps any_steps_of(const PointCloud2& cloud) {
    const Part first = any_part_of_cloud(cloud.height, cloud.width);
    const std::uint32_t rows = first.rows.size_of(cloud.height);
    return steps_of<PointCloud2>("data", first, any_part_of_cloud(rows, first.columns.size_of(cloud.width)));
  }

  /// Returns true if the second step can take no points from the first step's result. Either the channels
  /// overlap so much that they are larger than the point, or the points have 0 bytes, which is a
  /// contradiction.
  bool is_lost_between(const PointCloud2& cloud, const Steps& steps) const {
    const Part* first = steps.first.part(data);
    if (first == nullptr || first->channels.empty()) return false;
    std::uint64_t bytes = 0;
    for (const PointField& field : test::cut_reference::channels_of(cloud, first->channels))
      bytes += std::uint64_t{test::cut_reference::bytes_of_datatype(field.datatype)} * field.count;
    if (bytes > 0) return bytes > cloud.point_step;
    const bool has_points = first->rows.size_of(cloud.height) > 0 && first->columns.size_of(cloud.width) > 0;
    return has_points && steps.second.part(data) != nullptr;
  }

  /// Compares two steps with one step. Returns the number of bytes of points in the result.
  std::size_t expect_same_points(const PointCloud2& cloud, const Steps& steps) const {
    const Taken<PointCloud2> whole(cloud);
    const Taken<PointCloud2> two = whole.part(steps.first).part(steps.second), one = whole.part(steps.both);
    PointCloud2 expected = one.message();
    if (is_lost_between(cloud, steps)) {
      expected.height = expected.width = expected.row_step = 0;
      expected.data.clear();
    }
    EXPECT_TRUE(is_same(two, Taken<PointCloud2>(expected, one.mask()))) << words<PointCloud2>(steps);
    return expected.data.size();
  }

  const std::uint32_t data = leaf<PointCloud2>("data");
};

/// Returns a cloud of 4 rows of 6 points with x, y, z, an intensity and a ring. Each row has 5 bytes of
/// padding.
PointCloud2 cloud_of_24_points() {
  PointCloud2 cloud;
  cloud.header.frame_id = "lidar";
  cloud.height = 4;
  cloud.width = 6;
  cloud.point_step = 20;
  cloud.row_step = 125;
  for (std::uint32_t i = 0; i < 500; ++i) cloud.data.push_back(static_cast<std::uint8_t>(i % 251));
  const auto add = [&cloud](const char* name, std::uint32_t offset, std::uint8_t datatype) {
    PointField& field = cloud.fields.emplace_back();
    field.name = name;
    field.offset = offset;
    field.datatype = datatype;
    field.count = 1;
  };
  add("intensity", 12, PointField::FLOAT32);
  add("x", 0, PointField::FLOAT32);
  add("y", 4, PointField::FLOAT32);
  add("z", 8, PointField::FLOAT32);
  add("ring", 17, PointField::UINT16);
  return cloud;
}

TEST_F(CloudsOfClouds, HaveThePointsOfTheSelectionThatBothStepsMakeTogether) {
  const PointCloud2 cloud = cloud_of_24_points();
  const Steps steps = steps_by_text<PointCloud2>("header, data{x,y,z,intensity}[rows 1:4, columns ::2]",
                                                 "data{x,y,z}[rows ::2, columns 1:]",
                                                 "data{x,y,z}[rows 1:4:2, columns 2::2]");
  const PointCloud2 some = expect_same_bytes(cloud, steps).message();
  ASSERT_EQ(some.fields.size(), 3U);
  EXPECT_EQ(some.fields[2].name, "z");
  EXPECT_EQ(some.fields[2].offset, 8U);
  EXPECT_EQ(some.point_step, 12U);
  EXPECT_EQ(some.height, 2U);
  EXPECT_EQ(some.width, 2U);
  std::vector<std::uint8_t> points;
  for (const std::size_t row : {1U, 3U}) {
    for (const std::size_t column : {2U, 4U}) {
      const std::size_t first = row * cloud.row_step + column * cloud.point_step;
      for (std::size_t byte = 0; byte < 12; ++byte) points.push_back(cloud.data.at(first + byte));
    }
  }
  EXPECT_EQ(some.data, points);
}

TEST_F(CloudsOfClouds, OfAnyChannelsAndWindowsAreThoseOfTheSelectionOfBoth) {
  int with_points = 0;
  for (int round = 0; round < rounds() && !HasFailure(); ++round) {
    SCOPED_TRACE("round " + std::to_string(round));
    const PointCloud2 cloud = layouts.cloud();
    with_points += expect_same_points(cloud, any_steps_of(cloud)) > 0 ? 1 : 0;
  }
  EXPECT_GT(with_points, rounds() / 4) << "else the parts are dull";
}

TEST_F(CloudsOfClouds, WithFewerChannelsInEachStepAreThoseOfTheSelectionOfBoth) {
  int with_points = 0;
  for (int round = 0; round < rounds() && !HasFailure(); ++round) {
    SCOPED_TRACE("round " + std::to_string(round));
    const PointCloud2 cloud = layouts.cloud();
    Part first{.rows = layouts.range_with_some(cloud.height),
               .columns = layouts.range_with_some(cloud.width),
               .channels = {"x", "y", "z", "intensity"}};
    Part second{.rows = layouts.range_with_some(first.rows.size_of(cloud.height)),
                .columns = layouts.range_with_some(first.columns.size_of(cloud.width)),
                .channels = {"x", "y", "z"}};
    const Steps steps = steps_of<PointCloud2>("data", first, second);
    ASSERT_EQ(steps.both.part(data)->channels, second.channels);
    with_points += expect_same_points(cloud, steps) > 0 ? 1 : 0;
  }
  EXPECT_GT(with_points, rounds() / 2);
}

TEST_F(CloudsOfClouds, AreEmptyWhereOneOfTheStepsIsEmpty) {
  const PointCloud2 cloud = cloud_of_24_points();
  constexpr std::array<std::array<std::string_view, 3>, 7> texts{
      {{"data{x,y,z,intensity}[rows 9:]", "data{x,y,z}[columns 1:]", "data{x,y,z}[rows 9:, columns 1:]"},
       {"data{x,y,z,intensity}[columns 1:]", "data{x,y,z}[rows 9:]", "data{x,y,z}[rows 9:, columns 1:]"},
       {"data{x,y}[rows 1:3]", "data{x}[rows 2:]", "data{x}[rows 0:0]"},
       {"data{x,ring}[columns ::100]", "data{ring}[columns 1:]", "data{ring}[columns 100:]"},
       {"data[rows ::4000000000]", "data{z}[rows 2::4000000000]", "data{z}[rows 0:0]"},
       {"data[columns 0:0]", "data[columns 0:0]", "data[columns 0:0]"},
       {"data{x}[rows 4:]", "data[columns 6:]", "data{x}[rows 4:, columns 6:]"}}};
  for (const auto& [first, second, both] : texts) {
    const PointCloud2 none =
        expect_same_bytes(cloud, steps_by_text<PointCloud2>(first, second, both)).message();
    EXPECT_TRUE(none.data.empty()) << both;
    EXPECT_EQ(none.height * none.width, 0U) << both;
  }
}

TEST_F(CloudsOfClouds, WithChannelsOfTheSecondStepOnlyHaveNone) {
  const PointCloud2 cloud = cloud_of_24_points();
  const Steps steps =
      steps_by_text<PointCloud2>("data{x,y}[::2]", "data{z,ring}[1:]", "data{in neither step}[2::2]");
  const PointCloud2 none = expect_same_bytes(cloud, steps).message();
  EXPECT_TRUE(none.fields.empty());
  EXPECT_TRUE(none.data.empty());
  EXPECT_EQ(none.point_step, 0U);
}

TEST_F(CloudsOfClouds, ThatContradictThemselvesAreEmptyInOneStepAndInTwo) {
  constexpr std::uint32_t largest = std::numeric_limits<std::uint32_t>::max();
  int contradictions = 0;
  for (int round = 0; round < rounds() && !HasFailure(); ++round) {
    SCOPED_TRACE("round " + std::to_string(round));
    PointCloud2 cloud = layouts.cloud();
    const std::array numbers{&cloud.height, &cloud.width, &cloud.point_step, &cloud.row_step};
    const std::array lies{0U, 1U, 1U << 16, 1U << 31, largest - 1, largest, *numbers[layouts.below(4)] + 1};
    *numbers[layouts.below(4)] = lies[layouts.below(lies.size())];
    if (layouts.one_in(4)) cloud.data.resize(layouts.below(cloud.data.size()));
    if (!lacks_room(cloud.height, cloud.width, cloud.point_step, cloud.row_step, cloud.data.size())) continue;
    const Part first = any_part_of_cloud(9, 9);
    const Steps steps = steps_of<PointCloud2>("data", first, any_part_of_cloud(5, 5));
    if (steps.both.part(data) == nullptr) continue;  // without a part, the sizes in the cloud do not matter
    ++contradictions;
    const PointCloud2 none = expect_same_bytes(cloud, steps).message();
    EXPECT_TRUE(none.data.empty());
    EXPECT_EQ(none.height, 0U);
    EXPECT_EQ(none.width, 0U);
    EXPECT_EQ(none.row_step, 0U);
  }
  EXPECT_GT(contradictions, rounds() / 4);
}

// ---- scans ----

/// The largest relative error of a number that is rounded to a float.
constexpr double half_ulp = 0x1p-24;

class ScansOfScans : public PartOfPartTest {
 protected:
  /// Returns a part of one list or of both, sometimes with different ranges.
  std::vector<Part> parts_of_lists(const Range& range, std::uint32_t beams) {
    const Part of_ranges{.leaf = lists[0], .columns = range};
    Part of_intensities{.leaf = lists[1], .columns = range};
    const std::uint32_t which = layouts.below(8);
    if (which == 0) return {of_ranges};
    if (which == 1) return {of_intensities};
    if (which == 2) of_intensities.columns = any_range(beams);
    return {of_ranges, of_intensities};
  }
  Steps any_steps_of(const LaserScan& scan) {
    const auto beams = static_cast<std::uint32_t>(scan.ranges.size());
    const Range first = any_range(beams);
    const std::vector<Part> first_parts = parts_of_lists(first, beams);
    const std::uint32_t left = first.size_of(beams);
    const Range second = any_range(left);
    return steps_of<LaserScan>(
        first_parts, parts_of_lists(second, left), [this](const Selection& before, const Selection& behind) {
          return parts_of(behind, lists, together(common_part(before, lists), common_part(behind, lists)));
        });
  }

  /// Returns a scan with as many intensities as ranges, with no intensities, or sometimes with another
  /// number of intensities.
  LaserScan any_scan() {
    LaserScan scan = layouts.scan();
    if (layouts.one_in(8)) scan.intensities.resize(layouts.below(scan.ranges.size() + 3));
    return scan;
  }
  /// Returns a scan with numbers that are sums of few powers of two, so that nothing is ever rounded.
  LaserScan any_exact_scan() {
    LaserScan scan = any_scan();
    scan.angle_min = std::round(scan.angle_min * 64) / 64;
    scan.angle_increment = static_cast<float>(1 + layouts.below(32)) / (layouts.one_in(4) ? -4096 : 4096);
    scan.time_increment = static_cast<float>(layouts.below(32)) * 0x1p-20F;
    return scan;
  }

  /// The largest possible differences between numbers that are rounded once if cut in one step, and twice
  /// if cut in two steps.
  struct Bounds {
    double angle_min;
    double angle_max;
    double of_steps;  ///< relative to the increments
  };
  static Bounds bounds_of(const LaserScan& scan, const Range& first, const Range& second, std::size_t beams) {
    const double step = scan.angle_increment, step_between = step * first.step;
    const double to_first = first.begin * step, to_second = second.begin * step_between;
    const double to_last = (static_cast<double>(beams) - 1) * second.step * step_between;
    const double between = scan.angle_min + to_first, least = between + to_second;
    // Two steps also round the intermediate least angle and increment. Both ways round their results.
    const double of_double = 0x1p-50 * (std::abs(double{scan.angle_min}) + std::abs(to_first) +
                                        std::abs(to_second) + std::abs(to_last));
    return {
        .angle_min = half_ulp * (std::abs(between) + std::abs(to_second) + 2 * std::abs(least)) + of_double,
        .angle_max =
            half_ulp * (std::abs(between) + std::abs(to_second + to_last) + 2 * std::abs(least + to_last)) +
            of_double,
        .of_steps = 3 * half_ulp};
  }

  /// Expects the numbers of `two`, which two steps took, to be close to the numbers of `one`. Then copies the
  /// numbers of `one` to `two`. A scan without beams has no first and no last angle, and a single beam has no
  /// step.
  void settle_numbers(LaserScan& two, const LaserScan& one, std::size_t beams, const Bounds& bounds,
                      double forgotten) {
    constexpr double slack = 1 + 1e-6;  // for the errors of errors, since rounded numbers are rounded again
    const auto near = [](float a, double b, double bound) { EXPECT_NEAR(double{a}, b, bound * slack); };
    if (beams > 0) {
      const double step = one.angle_increment * forgotten, interval = one.time_increment * forgotten;
      near(two.angle_min, one.angle_min, bounds.angle_min);
      near(two.angle_max, one.angle_max, bounds.angle_max);
      near(two.angle_increment, step, bounds.of_steps * std::abs(step));
      near(two.time_increment, interval, bounds.of_steps * std::abs(interval));
    } else {
      EXPECT_TRUE(std::isfinite(two.angle_min) && std::isfinite(two.angle_max));
    }
    two.angle_min = one.angle_min;
    two.angle_max = one.angle_max;
    two.angle_increment = one.angle_increment;
    two.time_increment = one.time_increment;
  }

  /// Compares two steps with one step. Returns true if the result is a part and has more than one beam.
  bool expect_same_beams(const LaserScan& scan, const Steps& steps, bool is_exact) {
    const Taken<LaserScan> whole(scan);
    const Taken<LaserScan> two = whole.part(steps.first).part(steps.second), one = whole.part(steps.both);
    const Range first = common_part(steps.first, lists).columns;
    const Range second = common_part(steps.second, lists).columns;
    const Range both = common_part(steps.both, lists).columns;
    const double forgotten = forgotten_step(first, second, both);
    LaserScan of_two = two.message();
    const LaserScan of_one = one.message();
    const bool has_ranges = one.mask().contains(lists[0]);
    const std::size_t beams = (has_ranges ? of_one.ranges : of_one.intensities).size();
    // If the lists have different lengths, the last angle is that of the first list that is selected.
    if (!has_ranges && steps.first.mask().contains(lists[0]) && scan.ranges.size() != scan.intensities.size())
      of_two.angle_max = of_one.angle_max;
    const Bounds bounds = is_exact ? Bounds{} : bounds_of(scan, first, second, beams);
    settle_numbers(of_two, of_one, beams, bounds, forgotten);
    EXPECT_TRUE(is_same(Taken<LaserScan>(of_two, two.mask()), one)) << words<LaserScan>(steps);
    return beams > 1 && forgotten == 1 && !both.is_all();
  }

  const std::array<std::uint32_t, 2> lists{leaf<LaserScan>("ranges"), leaf<LaserScan>("intensities")};
};

TEST_F(ScansOfScans, HaveTheRangesAndIntensitiesOfTheSameBeams) {
  LaserScan scan;
  scan.angle_min = -1.5F;
  scan.angle_increment = 0.125F;
  scan.time_increment = 0x1p-10F;
  for (int beam = 0; beam < 24; ++beam) {
    scan.ranges.push_back(static_cast<float>(beam));
    scan.intensities.push_back(static_cast<float>(100 + beam));
  }
  const Steps steps =
      steps_by_text<LaserScan>("ranges[2:20:3], intensities[2:20:3]", "ranges[1::2], intensities[1::2]",
                               "ranges[5:20:6], intensities[5:20:6]");
  const LaserScan some = expect_same_bytes(scan, steps).message();
  EXPECT_EQ(some.ranges, (std::vector<float>{5, 11, 17}));
  EXPECT_EQ(some.intensities, (std::vector<float>{105, 111, 117}));
  EXPECT_EQ(some.angle_min, -1.5F + 5 * 0.125F);
  EXPECT_EQ(some.angle_max, -1.5F + 17 * 0.125F);
  EXPECT_EQ(some.angle_increment, 6 * 0.125F);
  EXPECT_EQ(some.time_increment, 6 * 0x1p-10F);
}

TEST_F(ScansOfScans, AreWholeInAStepThatAsksForTheirListsWithDifferentRanges) {
  const LaserScan scan = any_exact_scan();
  const auto steps = [](const std::string& first, const std::string& second, const std::string& both) {
    const std::string numbers = "angle_min, angle_max, angle_increment, time_increment, ";
    return steps_by_text<LaserScan>(numbers + first, numbers + second, numbers + both);
  };
  const char* const window = "ranges[1:], intensities[1:]";
  const char* const different = "ranges[::2], intensities[::3]";
  const char* const whole = "ranges, intensities";
  expect_same_bytes(scan, steps(different, window, window));
  expect_same_bytes(scan, steps(window, different, window));
  expect_same_bytes(scan, steps(different, different, whole));
  expect_same_bytes(scan, steps(different, "intensities[1:]", "intensities[1:]"));
}

TEST_F(ScansOfScans, AreThoseOfTheRangeOfBothUpToOneRoundingMore) {
  int with_beams = 0;
  for (int round = 0; round < 2 * rounds() && !HasFailure(); ++round) {
    SCOPED_TRACE("round " + std::to_string(round));
    const LaserScan scan = any_scan();
    with_beams += expect_same_beams(scan, any_steps_of(scan), false) ? 1 : 0;
  }
  EXPECT_GT(with_beams, rounds() / 4) << "else the parts are dull";
}

TEST_F(ScansOfScans, AreJustThoseOfTheRangeOfBothWhereNothingIsRounded) {
  int with_beams = 0;
  for (int round = 0; round < 2 * rounds() && !HasFailure(); ++round) {
    SCOPED_TRACE("round " + std::to_string(round));
    const LaserScan scan = any_exact_scan();
    with_beams += expect_same_beams(scan, any_steps_of(scan), true) ? 1 : 0;
  }
  EXPECT_GT(with_beams, rounds() / 4);
}

TEST_F(ScansOfScans, AreEmptyWhereOneOfTheStepsIsEmpty) {
  LaserScan scan = any_exact_scan();
  scan.ranges.assign(20, 1.F);
  scan.intensities.assign(20, 2.F);
  constexpr std::array<std::array<std::string_view, 3>, 4> texts{
      {{"ranges[20:], intensities[20:]", "ranges[3:], intensities[3:]", "ranges[23:], intensities[23:]"},
       {"ranges[::40], intensities[::40]", "ranges[1:], intensities[1:]",
        "ranges[40::40], intensities[40::40]"},
       {"ranges[4:4], intensities[4:4]", "ranges[::2], intensities[::2]", "ranges[0:0], intensities[0:0]"},
       {"ranges[5:9], intensities[5:9]", "ranges[4:], intensities[4:]", "ranges[0:0], intensities[0:0]"}}};
  for (const auto& [first, second, both] : texts) {
    const Steps steps = steps_by_text<LaserScan>(first, second, both);
    expect_same_beams(scan, steps, true);
    const LaserScan none = Taken<LaserScan>(scan).part(steps.both).message();
    EXPECT_TRUE(none.ranges.empty() && none.intensities.empty()) << both;
  }
}

}  // namespace
}  // namespace sft
