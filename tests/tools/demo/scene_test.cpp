// Tests of the generated yard.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <vector>

#include "tools/demo/scene.h"

namespace sft::demo {
namespace {

using Scan = std::vector<std::uint8_t>;

Scan scan_at(double seconds) {
  Scan scan(Scene::bytes);
  Scene::render(seconds, scan);
  return scan;
}

LidarPoint point_at(const Scan& scan, std::uint32_t row, std::uint32_t column) {
  LidarPoint point;
  std::memcpy(&point, scan.data() + (row * Scene::columns + column) * sizeof point, sizeof point);
  return point;
}

std::uint32_t points_with_return(const Scan& scan) {
  std::uint32_t returns = 0;
  for (std::uint32_t i = 0; i < Scene::points; ++i) returns += point_at(scan, 0, i).range != 0 ? 1 : 0;
  return returns;
}

TEST(Scene, IsTheSameWheneverItIsRendered) { EXPECT_EQ(scan_at(0.3), scan_at(0.3)); }

TEST(Scene, FillsEveryByteItIsGiven) {
  Scan on_zeros(Scene::bytes, 0x00);
  Scan on_ones(Scene::bytes, 0xff);
  Scene::render(1.0, on_zeros);
  Scene::render(1.0, on_ones);
  EXPECT_EQ(on_zeros, on_ones);
}

TEST(Scene, HasAWallThatMoves) {
  std::uint32_t moved = 0;
  const Scan before = scan_at(5.0);
  const Scan after = scan_at(5.5);
  for (std::uint32_t i = 0; i < Scene::points; ++i) {
    const auto millimetres =
        static_cast<std::int64_t>(point_at(before, 0, i).range) - point_at(after, 0, i).range;
    moved += std::abs(millimetres) > 500 ? 1 : 0;
  }
  EXPECT_GT(moved, Scene::points / 8);
  EXPECT_LT(moved, Scene::points * 3 / 4) << "the ground stays";
}

TEST(Scene, IsMostlyHit) {
  const std::uint32_t returns = points_with_return(scan_at(0));
  EXPECT_GT(returns, Scene::points * 3 / 4);
  EXPECT_LT(returns, Scene::points);
}

TEST(Scene, HasGroundBelowAndSkyAbove) {
  const Scan scan = scan_at(0);
  for (std::uint32_t column = 0; column < Scene::columns; ++column) {
    const LidarPoint lowest = point_at(scan, Scene::rows - 1, column);
    EXPECT_GE(lowest.z, -2.1F);
    EXPECT_LT(lowest.z, 0.0F);
    EXPECT_LE(point_at(scan, 0, column).z, 6.0F) << "the upper edge of the wall";
  }
}

TEST(Scene, HasRangesThatFitItsPoints) {
  const Scan scan = scan_at(2.0);
  for (std::uint32_t i = 0; i < Scene::points; ++i) {
    const LidarPoint p = point_at(scan, 0, i);
    ASSERT_EQ(p.ring, i / Scene::columns);
    ASSERT_NEAR(std::hypot(p.x, p.y, p.z) * 1000, p.range, 2.0) << "point " << i;
  }
}

}  // namespace
}  // namespace sft::demo
