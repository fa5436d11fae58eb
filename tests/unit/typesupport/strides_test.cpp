// The places of points and cells in memory, for readers that learn the types of channels from the cloud.
#include "sft/strides.h"

#include <array>
#include <nav_msgs/msg/OccupancyGrid.hpp>
#include <sensor_msgs/msg/Image.hpp>
#include <tuple>

#include "sft/points.h"
#include "tests/support/point_cloud.h"

namespace sft {
namespace {

using Kind = StructType::Member::Kind;
using sensor_msgs::msg::PointCloud2;
using test::Arrived;
using test::message_of;

class StridesTest : public test::RandomTest {};

Result<Strides> points_in(const DynamicView& view, std::vector<std::string_view> names) {
  return point_strides_of(view, names);
}

TEST_F(StridesTest, PointsAreWhereTheTypedOnesAreAndHaveTheTypesOfTheCloud) {
  const PointCloud2 whole = test::random_cloud(random, 5, 7);
  for (const char* selection : {"*", "data{phase,x,time}"}) {
    const Arrived sample(whole, selection);
    const auto found = points_in(sample.dynamic_view(), {"time", "x", "phase"});
    ASSERT_TRUE(found) << message_of(found);
    EXPECT_EQ(found->rows, 5U);
    EXPECT_EQ(found->columns, 7U);
    EXPECT_FALSE(found->is_swapped);
    ASSERT_EQ(found->channels.size(), 3U);
    EXPECT_EQ(found->channels[0].kind, Kind::float64);
    EXPECT_EQ(found->channels[1].kind, Kind::float32);
    EXPECT_EQ(found->channels[2].kind, Kind::int32);
    EXPECT_EQ(found->channels[0].count, 1U);
    EXPECT_EQ(found->channels[2].count, 3U);
    const auto typed = points_of<double>(sample.dynamic_view(), "time").value();
    for (std::size_t row = 0; row < found->rows; ++row) {
      for (std::size_t column = 0; column < found->columns; ++column) {
        const double expected = std::get<0>(typed.at(row, column));
        const std::byte* const at = found->first + row * found->row_step + column * found->column_step;
        EXPECT_EQ(std::memcmp(at + found->channels[0].offset, &expected, sizeof expected), 0);
      }
    }
  }
}

TEST_F(StridesTest, AChannelThatCannotBeReadIsAnErrorThatNamesIt) {
  const Arrived sample(test::random_cloud(random, 2, 2));
  const DynamicView view = sample.dynamic_view();
  EXPECT_EQ(message_of(points_in(view, {"x", "w"})), message_of(points_of<float>(view, "w")));
  EXPECT_EQ(message_of(points_in(view, {"none"})), message_of(points_of<float>(view, "none")));
  EXPECT_EQ(message_of(points_in(view, {"odd"})), message_of(points_of<float>(view, "odd")));
  EXPECT_EQ(message_of(points_in(view, {"far"})), message_of(points_of<float>(view, "far")));
  EXPECT_EQ(message_of(points_in(view["header"], {"x"})), "'header' is std_msgs::msg::Header, not a cloud");
}

TEST_F(StridesTest, CellsAreThePixelsOfAnImageAndTheCellsOfAMap) {
  sensor_msgs::msg::Image image{.height = 3, .width = 4, .encoding = "rgb8", .step = 15};
  image.data.resize(45);
  const Arrived pixels(image);
  const auto found = strides_of(pixels.dynamic_view(), "data", 3);
  ASSERT_TRUE(found) << message_of(found);
  EXPECT_EQ((std::array{found->rows, found->columns, found->row_step, found->column_step}),
            (std::array<std::size_t, 4>{3, 4, 15, 3}));
  EXPECT_FALSE(strides_of(pixels.dynamic_view(), "data", 4));
  EXPECT_FALSE(strides_of(pixels.dynamic_view(), "header", 1));
  nav_msgs::msg::OccupancyGrid map{};
  map.info.width = 4;
  map.info.height = 2;
  map.data.resize(8);
  const Arrived grid(map);
  const auto cells = strides_of(grid.dynamic_view(), "data", 1);
  ASSERT_TRUE(cells) << message_of(cells);
  EXPECT_EQ((std::array{cells->rows, cells->columns, cells->row_step, cells->column_step}),
            (std::array<std::size_t, 4>{2, 4, 4, 1}));
}

}  // namespace
}  // namespace sft
