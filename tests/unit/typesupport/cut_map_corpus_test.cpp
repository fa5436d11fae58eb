// Windows of a recorded map, as an occupancy grid and as a grey image. Cyclone DDS can read the windows.
// Each cell keeps its value and its place in the world, and each pixel its value. Needs the recordings,
// which are not in the repository (recorded_data.h).
#include <gtest/gtest.h>
#include <nav_msgs/msg/OccupancyGrid.h>
#include <sensor_msgs/msg/Image.h>

#include <cmath>
#include <filesystem>
#include <nav_msgs/msg/OccupancyGrid.hpp>
#include <sensor_msgs/msg/Image.hpp>
#include <string>
#include <utility>

#include "tests/support/cut.h"
#include "tests/support/cyclone_cdr.h"
#include "tests/support/grey_map.h"
#include "tests/support/recorded_data.h"

namespace sft {
namespace {

using nav_msgs::msg::OccupancyGrid;
using sensor_msgs::msg::Image;

struct Point {
  double x = 0, y = 0;
};

/// Returns the centre of a cell in the world. The origin of the map rotates and moves the cell's place on the
/// grid (see the comments in nav_msgs/msg/OccupancyGrid). The grid is rotated about the vertical axis only.
template <class Info>
Point centre(const Info& info, double column, double row) {
  const double z = info.origin.orientation.z, w = info.origin.orientation.w;
  const double cosine = 1 - 2 * z * z, sine = 2 * w * z, resolution = info.resolution;
  const double x = (column + 0.5) * resolution, y = (row + 0.5) * resolution;
  return {info.origin.position.x + cosine * x - sine * y, info.origin.position.y + sine * x + cosine * y};
}

class CutMapCorpusTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(test::recorded_data()))
      GTEST_SKIP() << "there are no recordings in " << test::recorded_data();
    map_ = test::read_grey_map(test::recorded_data() / "maps/willow-full-0.05.pgm").value();
  }
  OccupancyGrid grid() const {
    OccupancyGrid grid = test::grid_of(map_, 0.05F);
    grid.info.origin.position.x = -12.5;
    grid.info.origin.position.y = 30;
    grid.info.origin.orientation.z = std::sin(0.2);
    grid.info.origin.orientation.w = std::cos(0.2);
    return grid;
  }

  test::GreyMap map_;
};

TEST_F(CutMapCorpusTest, AWindowOfTenByTenMetresKeepsEachCellInItsPlace) {
  const OccupancyGrid whole = grid();
  ASSERT_EQ(whole.info.width, 1165U);
  ASSERT_EQ(whole.info.height, 945U);
  const test::Cut<OccupancyGrid> window(whole,
                                        test::all_with<OccupancyGrid>("data[rows 400:600, columns 700:900]"));
  ASSERT_TRUE(window.ok());
  EXPECT_NEAR(static_cast<double>(window.bytes().size()) / static_cast<double>(whole.data.size()), 0.036,
              0.001);
  test::CycloneReader reader(nav_msgs_msg_OccupancyGrid_desc);
  const auto* some = static_cast<const nav_msgs_msg_OccupancyGrid*>(reader.deserialize(window.bytes()));
  ASSERT_NE(some, nullptr);
  ASSERT_EQ(some->info.width, 200U);
  ASSERT_EQ(some->info.height, 200U);
  ASSERT_EQ(some->data._length, 200U * 200U);
  EXPECT_EQ(some->info.resolution, 0.05F);
  for (std::uint32_t row = 0; row < 200; ++row) {
    for (std::uint32_t column = 0; column < 200; ++column) {
      ASSERT_EQ(some->data._buffer[200 * row + column], whole.data[1165 * (400 + row) + 700 + column]);
      const Point here = centre(some->info, column, row);
      const Point there = centre(whole.info, 700 + column, 400 + row);
      ASSERT_NEAR(here.x, there.x, 1e-5) << row << ", " << column;
      ASSERT_NEAR(here.y, there.y, 1e-5) << row << ", " << column;
    }
  }
}

TEST_F(CutMapCorpusTest, AGreyImageIsThinnedPixelByPixel) {
  const Image whole = test::image_of(map_);
  const test::Cut<Image> thin(whole, test::all_with<Image>("data[rows 5:900:3, columns 1::4]"));
  ASSERT_TRUE(thin.ok());
  test::CycloneReader reader(sensor_msgs_msg_Image_desc);
  const auto* some = static_cast<const sensor_msgs_msg_Image*>(reader.deserialize(thin.bytes()));
  ASSERT_NE(some, nullptr);
  ASSERT_EQ(some->height, 299U);
  ASSERT_EQ(some->width, 291U);
  ASSERT_EQ(some->step, some->width);
  EXPECT_STREQ(some->encoding, "mono8");
  ASSERT_EQ(some->data._length, 299U * 291U);
  for (std::uint32_t row = 0; row < some->height; ++row) {
    for (std::uint32_t column = 0; column < some->width; ++column)
      ASSERT_EQ(some->data._buffer[some->step * row + column],
                map_.grey[std::size_t{map_.width} * (5 + 3 * row) + 1 + 4 * column])
          << row << ", " << column;
  }
}

}  // namespace
}  // namespace sft
