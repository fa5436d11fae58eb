// Clouds with random bytes: no value is read from outside the data or the sample.
#include <algorithm>
#include <array>
#include <cstring>

#include "sft/dynamic_view.h"
#include "sft/points.h"
#include "tests/support/point_cloud.h"
#include "tests/support/random_layouts.h"

#ifndef SFT_TEST_ROUNDS
#define SFT_TEST_ROUNDS 20'000
#endif

namespace sft {
namespace {

using sensor_msgs::msg::PointCloud2;
using test::Arrived;

class PointsHostile : public test::RandomTest {
 protected:
  static int rounds() { return static_cast<int>(test::test_rounds(SFT_TEST_ROUNDS)); }

  /// Returns a number that often is close to the number that fits, and often causes an overflow.
  std::uint32_t number() {
    constexpr std::array<std::uint32_t, 12> odd{0,           1,           2,           3,
                                                0x7FFF'FFFF, 0x8000'0000, 0xFFFF'FFFF, 0xFFFF'FFFE,
                                                0x1'0000,    0xFFFF,      0x5555'5555, 0x1000'0000};
    switch (random() % 3) {
      case 0:
        return odd[random() % odd.size()];
      case 1:
        return static_cast<std::uint32_t>(random());
      default:
        return static_cast<std::uint32_t>(random() % 64);
    }
  }

  PointCloud2 cloud() {
    PointCloud2 cloud = test::random_cloud(random, layouts.below(5), layouts.below(9));
    for (std::uint32_t* field : {&cloud.height, &cloud.width, &cloud.point_step, &cloud.row_step}) {
      if (layouts.one_in(3)) *field = number();
    }
    for (auto& channel : cloud.fields) {
      if (layouts.one_in(4)) channel.offset = number();
      if (layouts.one_in(4)) channel.count = number();
      if (layouts.one_in(8)) channel.datatype = static_cast<std::uint8_t>(random());
    }
    if (layouts.one_in(3)) cloud.data.resize(layouts.below(cloud.data.size() + 1));
    cloud.is_bigendian = layouts.one_in(2);
    return cloud;
  }

  test::RandomLayouts layouts{random};
};

/// Reads all values, or only the corners' if there are very many. A sanitizer checks the reads.
template <class... Ts>
void read_all(const Cells<std::tuple<Ts...>>& points) {
  if (points.size() > 10'000) {
    for (const std::size_t i : {std::size_t{0}, points.columns() - 1, points.size() / 2, points.size() - 1}) {
      const auto point = points[i];
      asm volatile("" : : "m"(point));
    }
    return;
  }
  std::size_t count = 0;
  for (const auto point : points) {
    asm volatile("" : : "m"(point));
    ++count;
  }
  ASSERT_EQ(count, points.size());
  ASSERT_EQ(points.end() - points.begin(), static_cast<std::ptrdiff_t>(count));
}

TEST_F(PointsHostile, NoHeaderLeadsOutOfTheData) {
  std::size_t with_points = 0;
  for (int round = 0; round < rounds(); ++round) {
    const Arrived sample(cloud());
    ASSERT_TRUE(sample.is_good());
    const std::span data = std::as_bytes(sample.view().data());
    const auto place = detail::cloud_place_of(sample.dynamic_view(), {});
    ASSERT_TRUE(place);
    std::array<detail::WantedChannel, 3> wanted{{{"x", 7}, {"time", 8}, {"ring", 4}}};
    const std::array<std::size_t, 3> bytes{4, 8, 2};
    const auto grid = detail::find_points(*place, wanted);
    if (!grid) continue;
    with_points += grid->size() > 0 ? 1 : 0;
    ASSERT_LE(grid->size(), data.size());
    for (std::size_t row = 0; row < grid->rows && grid->size() > 0; ++row) {
      for (const std::size_t column : {std::size_t{0}, std::size_t{grid->columns} - 1}) {
        for (std::size_t i = 0; i < wanted.size(); ++i) {
          const std::byte* value = grid->at(row, column) + wanted[i].offset;
          ASSERT_GE(value, data.data());
          ASSERT_LE(value + bytes[i], data.data() + data.size());
        }
      }
    }
    read_all(*sample.view().points<float, double, std::uint16_t>("x", "time", "ring"));
  }
  EXPECT_GT(with_points, 0U);
}

TEST_F(PointsHostile, NoBytesLeadOutOfTheSample) {
  for (int round = 0; round < rounds(); ++round) {
    Arrived sample(cloud());
    for (std::uint32_t changes = layouts.below(4); changes > 0; --changes) {
      const std::size_t bytes = std::min<std::size_t>(sample.body().size(), 700);  // the bytes of the header
      const std::uint32_t value = number();
      std::memcpy(sample.body().data() + layouts.below(bytes / 4) * 4, &value, sizeof value);
    }
    if (layouts.one_in(4)) sample.index()[layouts.below(sample.index().size())] = number();
    if (const auto points = sample.view().points<float, double, std::uint16_t>("x", "time", "ring"))
      read_all(*points);
    if (const auto points = points_of<float>(sample.dynamic_view(), "x")) read_all(*points);
  }
}

}  // namespace
}  // namespace sft
