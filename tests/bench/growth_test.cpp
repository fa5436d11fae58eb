// These tests check how ./run bench many fits the growth of costs, and how it shows the growth.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "bench/many/curve.h"

namespace sft::bench {

namespace {

TEST(BenchGrowth, IsTheExponentOfThePowerOfTheSize) {
  EXPECT_NEAR(exponent({{25, 3 * 25.}, {50, 3 * 50.}, {100, 3 * 100.}}), 1, 1e-9);
  EXPECT_NEAR(exponent({{25, 7 * 625.}, {100, 7 * 10'000.}}), 2, 1e-9);
  EXPECT_NEAR(exponent({{25, 4}, {50, 4}, {200, 4}}), 0, 1e-9);
}

TEST(BenchGrowth, LeavesOutSizesThatWereNotMeasured) {
  EXPECT_NEAR(exponent({{25, 5}, {50, 10}, {100, std::numeric_limits<double>::quiet_NaN()}, {200, 0}}), 1,
              1e-9);
}

TEST(BenchGrowth, IsNoNumberWithOneSize) {
  EXPECT_FALSE(std::isfinite(exponent({{25, 5}})));
  EXPECT_FALSE(std::isfinite(exponent({})));
}

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

TEST(BenchCurve, HasTheMediansOfEachSizeAndTheExponentsOfBothContenders) {
  Curve curve("growth_readers", {1, 4}, {{"bytes", "B"}});
  for (const double bytes : {100., 90., 5000.}) curve.add_ours(1, {bytes});
  curve.add_ours(4, {1600});
  curve.add_reference(1, {200});
  curve.add_reference(4, {200});
  const std::vector<Figure> figures = curve.figures();
  ASSERT_EQ(figures.size(), 3u);
  EXPECT_EQ(figures[0].name, "growth_readers_1_bytes");
  EXPECT_EQ(figures[0].value, 100);
  EXPECT_EQ(figures[0].reference, 200);
  EXPECT_EQ(figures[1].name, "growth_readers_4_bytes");
  EXPECT_EQ(figures[2].name, "growth_readers_exponent_bytes");
  EXPECT_NEAR(figures[2].value, 2, 1e-9);
  EXPECT_NEAR(*figures[2].reference, 0, 1e-9);
}

TEST(BenchCurve, TakesBothExponentsOverTheSizesThatBothHaveCarried) {
  Curve curve("growth", {25, 50, 100}, {{"time", "s"}});
  curve.add_ours(25, {1});
  curve.add_ours(50, {2});
  curve.add_ours(100, {unknown});
  curve.add_reference(25, {1});
  curve.add_reference(50, {4});
  curve.add_reference(100, {1000});
  const std::vector<Figure> figures = curve.figures();
  EXPECT_TRUE(std::isnan(figures[2].value));
  EXPECT_NEAR(figures.back().value, 1, 1e-9);
  EXPECT_NEAR(*figures.back().reference, 2, 1e-9);
}

TEST(BenchCurve, ShowsARowForEachCostAndContender) {
  Curve curve("growth_masks", {1, 4}, {{"bytes", "B"}});
  curve.add_ours(1, {16'000});
  curve.add_ours(4, {64'000});
  const std::string table = curve.table();
  EXPECT_NE(table.find("bytes, B               SFT                   16000         64000"),
            std::string::npos);
  EXPECT_NE(table.find("Cyclone DDS             nan           nan"), std::string::npos);
}

}  // namespace

}  // namespace sft::bench
