// Parts of parts of maps and lists with a layout rule of the user. Two steps take the same elements, at the
// same place, as one step with the combined selection. Two steps may round numbers once more than one step.
// If the numbers of a message have so few bits that they are never rounded, all bytes are the same.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <layout_msgs/msg/Echoes.hpp>
#include <layout_msgs/msg/HeightMap.hpp>
#include <layout_msgs/msg/Spectrum.hpp>
#include <layouts.hpp>
#include <span>
#include <string>
#include <vector>

#include "tests/unit/typesupport/part_of_part.h"

namespace sft {
namespace {

using layout_msgs::msg::Echoes;
using layout_msgs::msg::HeightMap;
using layout_msgs::msg::Spectrum;
using nav_msgs::msg::OccupancyGrid;

/// The place of a map's cells.
struct Placement {
  double scale;
  std::array<double, 3> at;
};
template <class Pose>
Placement placement(double scale, const Pose& pose) {
  return {scale, {pose.position.x, pose.position.y, pose.position.z}};
}
Placement placement_of(const HeightMap& map) { return placement(map.resolution, map.origin); }
Placement placement_of(const layouts::HeightMap& map) {
  return placement(map.raster.cell, map.raster.corner);
}
Placement placement_of(const layouts::Mission& mission) { return placement_of(mission.ground); }

template <class Pose>
void put(Pose& pose, const Placement& placement) {
  pose.position.x = placement.at[0];
  pose.position.y = placement.at[1];
  pose.position.z = placement.at[2];
}
void place(HeightMap& map, const Placement& placement) {
  map.resolution = static_cast<float>(placement.scale);
  put(map.origin, placement);
}
void place(layouts::HeightMap& map, const Placement& placement) {
  map.raster.cell = placement.scale;
  put(map.raster.corner, placement);
}
void place(layouts::Mission& mission, const Placement& placement) { place(mission.ground, placement); }

bool has_cells(const HeightMap& map) { return map.rows > 0 && map.columns > 0; }
bool has_cells(const layouts::HeightMap& map) { return map.raster.lines > 0 && map.raster.width > 0; }
bool has_cells(const layouts::Mission& mission) { return has_cells(mission.ground); }

template <class Pose, class OtherPose>
void copy_pose(Pose& to, const OtherPose& from) {
  to.position.x = from.position.x;
  to.position.y = from.position.y;
  to.position.z = from.position.z;
  to.orientation.x = from.orientation.x;
  to.orientation.y = from.orientation.y;
  to.orientation.z = from.orientation.z;
  to.orientation.w = from.orientation.w;
}

/// The relative rounding errors of a scale, and of a place that is computed from the scale with double
/// precision.
struct Rounding {
  double scale;
  double place;
};
constexpr Rounding exact{0, 0};
// A place is computed three times: twice by two steps and once by one step. Each computation uses some 20
// rounded numbers.
constexpr Rounding of_floats{0x1p-24, 64 * 0x1p-53}, of_doubles{0x1p-53, 64 * 0x1p-53};

class UserMapsOfMaps : public PartOfPartTest {
 protected:
  /// Returns a grid whose numbers are sums of few powers of two and which is rotated by right angles only. So
  /// nothing is ever rounded.
  OccupancyGrid any_exact_grid() {
    constexpr std::array<std::array<double, 4>, 4> turns{
        {{0, 0, 0, 1}, {0, 0, 1, 0}, {1, 0, 0, 0}, {0.5, 0.5, 0.5, 0.5}}};
    OccupancyGrid grid = layouts.grid();
    grid.info.resolution = static_cast<float>(1 + layouts.below(8)) / 8;
    auto& [position, orientation] = grid.info.origin;
    position.x = std::round(position.x * 8) / 8;
    position.y = std::round(position.y * 8) / 8;
    position.z = std::round(position.z * 8) / 8;
    const std::array<double, 4>& turn = turns[layouts.below(turns.size())];
    orientation.x = turn[0];
    orientation.y = turn[1];
    orientation.z = turn[2];
    orientation.w = turn[3];
    return grid;
  }
  HeightMap map_of(const OccupancyGrid& grid) {
    HeightMap map;
    map.header = grid.header;
    map.rows = grid.info.height;
    map.columns = grid.info.width;
    map.resolution = grid.info.resolution;
    map.origin = grid.info.origin;
    map.heights = numbers<float>(grid.data.size());
    map.variances = numbers<float>(grid.data.size());
    map.note = "of the yard";
    return map;
  }
  layouts::HeightMap idl_map_of(const OccupancyGrid& grid) {
    layouts::HeightMap map;
    map.level = static_cast<std::uint8_t>(layouts.below(9));
    map.raster.lines = grid.info.height;
    map.raster.width = grid.info.width;
    map.raster.cell = grid.info.resolution;
    copy_pose(map.raster.corner, grid.info.origin);
    map.heights = numbers<std::int16_t>(grid.data.size());
    return map;
  }

  /// Returns parts whose rows and columns mostly have the same step, because a map with different steps stays
  /// whole. Sometimes the fields that share the layout have different parts.
  std::vector<Part> any_parts_of_map(std::span<const std::uint32_t> leaves, std::uint32_t rows,
                                     std::uint32_t columns) {
    std::vector<Part> parts;
    Part part = any_part(rows, columns);
    if (!layouts.one_in(8)) part.columns.step = part.rows.step;
    for (const std::uint32_t leaf : leaves) {
      if (layouts.one_in(12)) part.rows = {};
      part.leaf = leaf;
      parts.push_back(part);
    }
    return parts;
  }
  /// Returns the part that is taken. If rows and columns have different steps, this is the whole map.
  static Part taken_part(const Selection& selection, std::span<const std::uint32_t> leaves) {
    const Part part = common_part(selection, leaves);
    return part.rows.step == part.columns.step ? part : Part{};
  }
  /// Returns true if the part is empty and its steps differ. Then an empty map and the whole map are both
  /// right.
  static bool is_ambiguous(const Part& part, std::uint32_t rows, std::uint32_t columns) {
    return part.rows.step != part.columns.step &&
           (part.rows.size_of(rows) == 0 || part.columns.size_of(columns) == 0);
  }

  /// Expects the numbers of `two`, which two steps took, to be close to the numbers of `one`. Then copies the
  /// numbers of `one` to `two`.
  template <class T>
  static void settle(T& two, const T& one, const Placement& whole, const Steps& steps,
                     std::span<const std::uint32_t> leaves, const Rounding& rounding) {
    const Part first = taken_part(steps.first, leaves), second = taken_part(steps.second, leaves);
    const double forgotten = forgotten_step(first.rows, second.rows, taken_part(steps.both, leaves).rows);
    const auto moves = [](double scale, const Part& part) {
      return scale * part.rows.begin + scale * part.columns.begin;
    };
    const Placement of_two = placement_of(two), of_one = placement_of(one);
    const double second_move = moves(whole.scale * first.rows.step, second);
    const double size = std::abs(whole.at[0]) + std::abs(whole.at[1]) + std::abs(whole.at[2]) +
                        moves(whole.scale, first) + second_move;
    const double scale = of_one.scale * forgotten;
    EXPECT_NEAR(of_two.scale, scale, 3 * rounding.scale * scale * (1 + 1e-6));
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_NEAR(of_two.at[i], of_one.at[i], rounding.scale * second_move + rounding.place * size);
    place(two, of_one);
  }

  /// Compares two steps with one step. Returns true if the result has cells and is a part. The fields in
  /// `leaves` share the layout.
  template <class T>
  bool expect_same_map(const T& map, const OccupancyGrid& grid, std::span<const std::uint32_t> leaves,
                       const Rounding& rounding) {
    std::uint32_t rows = grid.info.height, columns = grid.info.width;
    const std::vector<Part> first_parts = any_parts_of_map(leaves, rows, columns);
    const std::uint32_t some_rows = first_parts[0].rows.size_of(rows);
    const std::uint32_t some_columns = first_parts[0].columns.size_of(columns);
    const std::vector<Part> second_parts = any_parts_of_map(leaves, some_rows, some_columns);
    Part both;
    const Steps steps =
        steps_of<T>(first_parts, second_parts, [&](const Selection& before, const Selection& behind) {
          both = together(taken_part(before, leaves), taken_part(behind, leaves));
          return parts_of(behind, leaves, both);
        });
    // A part of one row loses its step. If the columns of such a part keep a step, the map would stay whole.
    if (both.rows.step != both.columns.step) return false;
    if (is_ambiguous(common_part(steps.first, leaves), rows, columns)) return false;
    rows = taken_part(steps.first, leaves).rows.size_of(rows);
    columns = taken_part(steps.first, leaves).columns.size_of(columns);
    if (is_ambiguous(common_part(steps.second, leaves), rows, columns)) return false;
    const Taken<T> whole(map);
    const Taken<T> two = whole.part(steps.first).part(steps.second), one = whole.part(steps.both);
    T of_two = two.message();
    const T of_one = one.message();
    if (has_cells(of_one)) settle(of_two, of_one, placement_of(map), steps, leaves, rounding);
    place(of_two, placement_of(of_one));  // maps without cells may have any place
    EXPECT_TRUE(is_same(Taken<T>(of_two, two.mask()), one)) << words<T>(steps);
    return has_cells(of_one) && !both.is_whole();
  }

  /// Checks the law for maps that `make_map` makes from random grids.
  template <class T, class MakeMap>
  void expect_law(const std::vector<std::uint32_t>& leaves, const Rounding& rounding, MakeMap make_map) {
    int with_cells = 0;
    for (int round = 0; round < rounds() && !HasFailure(); ++round) {
      SCOPED_TRACE("round " + std::to_string(round));
      const OccupancyGrid grid = rounding.scale == 0 ? any_exact_grid() : layouts.grid();
      with_cells += expect_same_map<T>(make_map(grid), grid, leaves, rounding) ? 1 : 0;
    }
    EXPECT_GT(with_cells, rounds() / 4) << "else the parts are dull";
  }

  const std::vector<std::uint32_t> lists{leaf<HeightMap>("heights"), leaf<HeightMap>("variances")};
};

TEST_F(UserMapsOfMaps, HaveTheScaleAndTheOriginOfBothSteps) {
  HeightMap map;
  map.rows = map.columns = 9;
  map.resolution = 0.25F;
  map.origin.position.x = 10;
  map.origin.orientation.z = 1;  // rotated by half a turn
  map.origin.orientation.w = 0;
  for (int cell = 0; cell < 81; ++cell) map.heights.push_back(static_cast<float>(cell));
  map.variances = map.heights;
  const Steps steps =
      steps_by_text<HeightMap>("heights[rows 1::2, columns ::2], variances[rows 1::2, columns ::2]",
                               "heights[rows 1:4:2, columns 1:4:2], variances[rows 1:4:2, columns 1:4:2]",
                               "heights[rows 3:8:4, columns 2:7:4], variances[rows 3:8:4, columns 2:7:4]");
  const HeightMap some = expect_same_bytes(map, steps).message();
  EXPECT_EQ(some.heights, (std::vector<float>{29, 33, 65, 69}));
  EXPECT_EQ(some.variances, some.heights);
  EXPECT_EQ(some.rows, 2U);
  EXPECT_EQ(some.columns, 2U);
  EXPECT_EQ(some.resolution, 1.F);
  EXPECT_EQ(some.origin.position.x, 10 - 2 * 0.25);
  EXPECT_EQ(some.origin.position.y, -3 * 0.25);
}

TEST_F(UserMapsOfMaps, AreThoseOfTheSelectionOfBothUpToOneRoundingOfTheScaleMore) {
  expect_law<HeightMap>(lists, of_floats, [this](const OccupancyGrid& grid) { return map_of(grid); });
}

TEST_F(UserMapsOfMaps, AreJustThoseOfTheSelectionOfBothWhereNothingIsRounded) {
  expect_law<HeightMap>(lists, exact, [this](const OccupancyGrid& grid) { return map_of(grid); });
}

TEST_F(UserMapsOfMaps, OfAStructOfTheirOwnAreThoseOfTheSelectionOfBoth) {
  const std::vector<std::uint32_t> heights{leaf<layouts::HeightMap>("heights")};
  const auto make_map = [this](const OccupancyGrid& grid) { return idl_map_of(grid); };
  expect_law<layouts::HeightMap>(heights, of_doubles, make_map);
  expect_law<layouts::HeightMap>(heights, exact, make_map);
}

TEST_F(UserMapsOfMaps, InAMemberOfAnotherTypeAreThoseOfTheSelectionOfBoth) {
  expect_law<layouts::Mission>({leaf<layouts::Mission>("ground.heights")}, exact,
                               [this](const OccupancyGrid& grid) {
                                 layouts::Mission mission;
                                 mission.width = 77;
                                 mission.ground = idl_map_of(grid);
                                 return mission;
                               });
}

TEST_F(UserMapsOfMaps, ThatContradictThemselvesAreEmptyInOneStepAndInTwo) {
  for (int round = 0; round < rounds() / 4 && !HasFailure(); ++round) {
    SCOPED_TRACE("round " + std::to_string(round));
    HeightMap map = map_of(any_exact_grid());
    map.heights.resize(std::size_t{map.rows} * map.columns - 1);
    map.variances.resize(map.heights.size());
    if (layouts.one_in(2)) (layouts.one_in(2) ? map.rows : map.columns) = ~0U;
    const std::uint32_t step = 1 + layouts.below(3);
    const auto each = [](std::uint32_t begin, std::uint32_t every) {
      const std::string range = std::to_string(begin) + "::" + std::to_string(every);
      const std::string window = "[rows " + range + ", columns " + range + "]";
      return "heights" + window + ", variances" + window;
    };
    const Steps steps = steps_by_text<HeightMap>(each(1, step), each(1, 2), each(1 + step, 2 * step));
    const HeightMap none = expect_same_bytes(map, steps).message();
    EXPECT_TRUE(none.heights.empty() && none.variances.empty());
    EXPECT_EQ(none.rows, 0U);
    EXPECT_EQ(none.columns, 0U);
  }
}

// ---- lists ----

using Lists = std::vector<std::vector<double>>;

template <class List>
std::vector<double> doubles(const List& list) {
  return {list.begin(), list.end()};
}
Lists lists_of(const Spectrum& spectrum) { return {spectrum.power}; }
Lists lists_of(const layouts::Spectrum& spectrum) { return {spectrum.power, doubles(spectrum.phase)}; }
Lists lists_of(const Echoes& echoes) { return {doubles(echoes.echoes), doubles(echoes.noise)}; }

class UserListsOfLists : public PartOfPartTest {
 protected:
  /// Compares two steps with one step, with exact numbers. Expects the same bytes, unless the lists are empty
  /// or have lost their step. The fields in `leaves` share the layout. Returns true if the bytes were
  /// compared.
  template <class T>
  bool expect_same_lists(const T& message, const std::vector<std::uint32_t>& leaves) {
    const auto count = static_cast<std::uint32_t>(lists_of(message)[0].size());
    const Range first = any_range(count), second = any_range(first.size_of(count));
    const auto parts = [&](const Range& range) {
      std::vector<Part> result;
      for (const std::uint32_t leaf : leaves) result.push_back({.leaf = leaf, .columns = range});
      return result;
    };
    double forgotten = 0;
    Part both;
    const Steps steps =
        steps_of<T>(parts(first), parts(second), [&](const Selection& before, const Selection& behind) {
          const Part first_part = common_part(before, leaves), second_part = common_part(behind, leaves);
          both = together(first_part, second_part);
          forgotten = forgotten_step(first_part.columns, second_part.columns, both.columns);
          return parts_of(behind, leaves, both);
        });
    const Taken<T> whole(message);
    const Taken<T> two = whole.part(steps.first).part(steps.second), one = whole.part(steps.both);
    EXPECT_EQ(lists_of(two.message()), lists_of(one.message())) << words<T>(steps);
    if (both.columns.size_of(count) == 0 || forgotten != 1) return false;
    EXPECT_TRUE(is_same(two, one)) << words<T>(steps);
    return !both.is_whole();
  }
  template <class MakeMessage>
  void expect_law(const std::vector<std::uint32_t>& leaves, MakeMessage make_message) {
    int compared = 0;
    for (int round = 0; round < rounds() && !HasFailure(); ++round) {
      SCOPED_TRACE("round " + std::to_string(round));
      compared += expect_same_lists(make_message(), leaves) ? 1 : 0;
    }
    EXPECT_GT(compared, rounds() / 4) << "else the parts are dull";
  }
  std::size_t any_count() { return layouts.below(64); }
};

TEST_F(UserListsOfLists, SayOfWhichElementsTheyAre) {
  Echoes echoes;
  echoes.nearest = 0.5F;
  echoes.spacing = 0.25;
  echoes.interval = 0x1p-10F;
  for (std::uint8_t i = 0; i < 20; ++i) {
    echoes.echoes.push_back(i);
    echoes.noise.push_back(static_cast<std::int8_t>(-i));
  }
  const Steps steps = steps_by_text<Echoes>("echoes[2::3], noise[2::3]", "echoes[1::2], noise[1::2]",
                                            "echoes[5::6], noise[5::6]");
  const Echoes some = expect_same_bytes(echoes, steps).message();
  EXPECT_EQ(some.echoes, (std::vector<std::uint16_t>{5, 11, 17}));
  EXPECT_EQ(some.noise, (std::vector<std::int8_t>{-5, -11, -17}));
  EXPECT_EQ(some.nearest, 0.5F + 5 * 0.25F);
  EXPECT_EQ(some.farthest, 0.5 + 17 * 0.25);
  EXPECT_EQ(some.spacing, 6 * 0.25);
  EXPECT_EQ(some.interval, 6 * 0x1p-10F);
}

TEST_F(UserListsOfLists, OfASpectrumAreThoseOfTheSelectionOfBoth) {
  expect_law({leaf<Spectrum>("power")}, [this] {
    Spectrum spectrum;
    spectrum.first_frequency = 100 + layouts.below(64) / 64.0;
    spectrum.frequency_step = static_cast<float>(1 + layouts.below(16)) / 16;
    spectrum.last_frequency = 1e9;  // last_frequency must be ignored
    spectrum.power = numbers<double>(any_count());
    return spectrum;
  });
}

TEST_F(UserListsOfLists, ThatShareARuleAreThoseOfTheSelectionOfBoth) {
  expect_law({leaf<layouts::Spectrum>("power"), leaf<layouts::Spectrum>("phase")}, [this] {
    layouts::Spectrum spectrum;
    spectrum.from = static_cast<float>(layouts.below(64)) / 64;
    spectrum.step = static_cast<float>(1 + layouts.below(16)) / 16;
    spectrum.power = numbers<double>(any_count());
    spectrum.phase = numbers<float>(spectrum.power.size());
    return spectrum;
  });
}

TEST_F(UserListsOfLists, OfEchoesWithATimeBetweenThemAreThoseOfTheSelectionOfBoth) {
  expect_law({leaf<Echoes>("echoes"), leaf<Echoes>("noise")}, [this] {
    Echoes echoes;
    echoes.nearest = static_cast<float>(layouts.below(64)) / 64;
    echoes.farthest = 1e9;
    echoes.spacing = (1 + layouts.below(16)) / 256.0;
    echoes.interval = static_cast<float>(layouts.below(16)) * 0x1p-12F;
    echoes.echoes = numbers<std::uint16_t>(any_count());
    echoes.noise = numbers<std::int8_t>(echoes.echoes.size());
    return echoes;
  });
}

}  // namespace
}  // namespace sft
