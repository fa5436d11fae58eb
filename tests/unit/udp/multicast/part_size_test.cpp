// These tests compare the estimated bytes of parts of fields with the bytes of real projections.
#include "udp_transport/multicast/part_size.h"

#include <gtest/gtest.h>

#include <sensor_msgs/msg/LaserScan.hpp>
#include <string>
#include <vector>

#include "sft/detail/project.h"
#include "sft/dynamic_view.h"
#include "tests/support/point_cloud.h"
#include "udp_transport/multicast/body_sizes.h"

namespace sft::udp {
namespace {

using sensor_msgs::msg::LaserScan;
using sensor_msgs::msg::PointCloud2;
using sft::test::Arrived;

using Second = std::chrono::seconds;

template <class T>
Selection asked_of(const char* text) {
  const TypeSupport& type = type_support<T>();
  return type.closed(type.parse_selection(text).value());
}
template <class T>
double projected(const T& message, const Selection& selection) {
  detail::Projection projection;
  const Arrived<T> sample(message);
  EXPECT_TRUE(projection.project(sample.state(), detail::ProjectionPlan(type_support<T>(), selection)));
  return static_cast<double>(projection.bytes());
}

class PartSizeTest : public sft::test::RandomTest {
 protected:
  template <class T>
  void expect_near(const T& message, const char* text, double bytes_at_most) {
    BodySizes sizes(type_support<T>().type());
    const Selection selection = asked_of<T>(text);
    sizes.follow(type_support<T>(), {&selection, 1});
    EXPECT_FALSE(sizes.known(selection)) << text;
    const Arrived<T> sample(message);
    sizes.measure(sample.state(), BodySizes::Time{Second(1)});
    ASSERT_TRUE(sizes.known(selection)) << text;
    EXPECT_NEAR(sizes.bytes_of(selection), projected(message, selection), bytes_at_most) << text;
  }
};

/// The estimate ignores padding and the names of the channels of clouds that are not selected. Both take
/// only a few bytes.
TEST_F(PartSizeTest, IsThatOfTheProjectionButForAFewBytesOfACloud) {
  const PointCloud2 cloud = sft::test::random_cloud(random, 20, 100);
  for (const char* text :
       {"data{x,y,z}", "data{x}", "data{intensity,ring}[columns ::4]", "header.stamp, data[rows 3:5]",
        "data{x,y,z}[rows 2:11:3, columns 7:]", "data[1000:]", "data{missing}", "*, data[::2]"})
    expect_near(cloud, text, 400);
}

TEST_F(PartSizeTest, IsThatOfTheProjectionOfLists) {
  LaserScan scan;
  scan.ranges.assign(1000, 1);
  scan.intensities.assign(1000, 2);
  for (const char* text : {"ranges[::4]", "ranges[10:20], intensities", "intensities[5:], ranges[5:]",
                           "ranges[2000:]", "*, ranges[::7]"})
    expect_near(scan, text, 16);
}

TEST_F(PartSizeTest, IsUnknownUntilASampleHasAllOfTheFields) {
  const Selection some = asked_of<PointCloud2>("data{x}");
  PartSize size(type_support<PointCloud2>(), some);
  const Arrived<PointCloud2> part(sft::test::random_cloud(random, 2, 2), "height");
  size.measure(part.state());
  EXPECT_FALSE(size.known());
  const Arrived<PointCloud2> whole(sft::test::random_cloud(random, 2, 2));
  size.measure(whole.state());
  EXPECT_TRUE(size.known());
}

TEST_F(PartSizeTest, FollowsSamplesAsSlowlyAsTheSizesOfWholeFieldsDo) {
  const Selection half = asked_of<LaserScan>("ranges[::2]");
  BodySizes sizes(type_support<LaserScan>().type());
  sizes.follow(type_support<LaserScan>(), {&half, 1});
  Second now(1);
  const auto publish = [&](std::size_t beams) {
    LaserScan scan;
    scan.ranges.assign(beams, 1);
    const Arrived<LaserScan> sample(scan);
    sizes.measure(sample.state(), BodySizes::Time{now += Second(1)});
    return sizes.bytes_of(half);
  };
  const double before = publish(1000);
  EXPECT_NEAR(publish(2000), before + 500, 1) << "a quarter of 500 beams more";
  for (int i = 0; i < 50; ++i) publish(2000);
  EXPECT_NEAR(sizes.bytes_of(half), before + 2000, 1);
}

TEST_F(PartSizeTest, IsForgottenOnceNobodyAsksForThePart) {
  const Selection selections[] = {asked_of<LaserScan>("ranges[::2]"), asked_of<LaserScan>("ranges[::4]")};
  BodySizes sizes(type_support<LaserScan>().type());
  sizes.follow(type_support<LaserScan>(), selections);
  const auto first = sizes.part_size(selections[0]);
  ASSERT_NE(first, nullptr);
  sizes.follow(type_support<LaserScan>(), {selections, 1});
  EXPECT_EQ(sizes.part_size(selections[0]), first) << "what is known of it stays";
  EXPECT_EQ(sizes.part_size(selections[1]), nullptr);
}

/// The test puts random bytes into samples, as a program may do.
TEST_F(PartSizeTest, IgnoresBytesThatAreNotOfTheirType) {
  const Selection some = asked_of<PointCloud2>("data{x,y,z}[::2]");
  for (int i = 0; i < 2000; ++i) {
    Arrived<PointCloud2> sample(sft::test::random_cloud(random, 2, 3));
    PartSize size(type_support<PointCloud2>(), some);
    for (int changes = 0; changes < 4; ++changes)
      sample.body()[random() % sample.body().size()] = static_cast<std::byte>(random());
    if (i % 2 == 0) sample.index()[random() % sample.index().size()] = static_cast<std::uint32_t>(random());
    size.measure(sample.state());
    EXPECT_GE(size.bytes_less(), 0);
  }
}

}  // namespace
}  // namespace sft::udp
