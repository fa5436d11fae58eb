// A writer that sends a part takes one piece of memory for the part. Some bytes of the message may not have
// been copied into the sample yet when the part is cut.
#include <gtest/gtest.h>

#include <sensor_msgs/msg/JointState.hpp>
#include <sensor_msgs/msg/LaserScan.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>

#include "sft/detail/postponed_copies.h"
#include "tests/support/cut.h"
#include "tests/support/random_layouts.h"
#include "tests/support/random_value.h"

#ifndef SFT_TEST_ROUNDS
#define SFT_TEST_ROUNDS 1000
#endif

namespace sft {
namespace {

using sensor_msgs::msg::PointCloud2;

class CutMemory : public test::RandomTest {
 protected:
  static int rounds() { return static_cast<int>(test::test_rounds(SFT_TEST_ROUNDS)); }

  Selection part_of(const PointCloud2& cloud) {
    Selection::Part part{.leaf = static_cast<std::uint32_t>(*type.find("data")->begin()),
                         .rows = layouts.range(cloud.height),
                         .columns = layouts.range(cloud.width)};
    if (!layouts.one_in(3)) part.channels = layouts.channels();
    return type.closed(Selection::make(values.mask(type.leaves()), {part}, {}).value());
  }

  const TypeSupport& type = type_support<PointCloud2>();
  test::RandomLayouts layouts{random};
  test::RandomValues values{random};
};

TEST_F(CutMemory, HasTheBytesThatAProjectionWithoutItHas) {
  for (int round = 0; round < rounds(); ++round) {
    const PointCloud2 cloud = layouts.cloud();
    const detail::ProjectionPlan plan(type, part_of(cloud));
    if (!plan.has_parts()) continue;
    const test::Encoded source(cloud);
    detail::Projection alone, in_memory;
    ASSERT_TRUE(alone.project(source.state(), plan));
    std::vector<std::byte> memory(in_memory.bytes_most(source.state(), plan));
    ASSERT_TRUE(in_memory.project(source.state(), plan, memory)) << "in round " << round;
    ASSERT_LE(in_memory.segments().size(), 1U);
    ASSERT_EQ(test::gathered(in_memory), test::gathered(alone)) << "in round " << round;
  }
}

/// The fields that are not asked for are far larger than the part.
TEST_F(CutMemory, HasNoBytesOfFieldsThatAreNotAskedFor) {
  const auto expect_little = [](const TypeSupport& support, const test::Encoded& source, const char* text) {
    const detail::ProjectionPlan plan(support, support.closed(support.parse_selection(text).value()));
    detail::Projection projection;
    ASSERT_TRUE(projection.project(source.state(), plan));
    std::vector<std::byte> memory(projection.bytes_most(source.state(), plan));
    EXPECT_GE(memory.size(), projection.bytes()) << text;
    EXPECT_LT(memory.size(), projection.bytes() + 2000) << text;
    EXPECT_TRUE(projection.project(source.state(), plan, memory)) << text;
  };
  sensor_msgs::msg::LaserScan scan;
  scan.ranges.resize(3000);
  scan.intensities.resize(500'000);
  for (const char* text : {"ranges[:2]", "header, ranges[::3]", "ranges"})
    expect_little(type_support<sensor_msgs::msg::LaserScan>(), test::Encoded(scan), text);
  sensor_msgs::msg::JointState joints;
  for (int i = 0; i < 30; ++i) joints.name.push_back("joint");
  joints.position.resize(300'000);
  for (const char* text : {"name[:2]", "header, name[::3]"})
    expect_little(type_support<sensor_msgs::msg::JointState>(), test::Encoded(joints), text);
}

TEST_F(CutMemory, ThatIsTooLittleIsRefused) {
  PointCloud2 cloud;
  cloud.height = 4;
  cloud.width = 500;
  cloud.point_step = 16;
  cloud.row_step = 8000;
  cloud.data.resize(32'000);
  cloud.fields.push_back({.name = "x", .offset = 4, .datatype = 7, .count = 1});
  const test::Encoded source(cloud);
  for (const char* text : {"data{x}", "data[rows 1:3]", "data[columns ::2]", "header, data[:499]"}) {
    const detail::ProjectionPlan plan(type, type.closed(type.parse_selection(text).value()));
    detail::Projection projection;
    ASSERT_TRUE(projection.project(source.state(), plan));
    std::vector<std::byte> memory(projection.bytes());
    EXPECT_TRUE(projection.project(source.state(), plan, memory)) << text;
    memory.pop_back();
    EXPECT_FALSE(projection.project(source.state(), plan, memory)) << text;
  }
}

TEST_F(CutMemory, GetsPartsOfWhatHasNotBeenCopiedYet) {
  PointCloud2 cloud;
  cloud.header.frame_id = "lidar";
  cloud.height = 3;
  cloud.width = 2000;
  cloud.point_step = 20;
  cloud.row_step = 40'000;
  for (std::uint32_t i = 0; i < 120'000; ++i) cloud.data.push_back(static_cast<std::uint8_t>(i % 251));
  cloud.fields.push_back({.name = "x", .offset = 4, .datatype = 7, .count = 1});
  const test::Encoded whole(cloud);
  test::Encoded source(cloud);
  std::memset(source.body(), 0xAA, source.state().body_bytes);
  detail::PostponedCopies postponed;
  detail::encode(type.type(), &cloud, type.full(), {source.body(), source.state().body_bytes},
                 {source.index(), source.slots()}, {}, &postponed);
  ASSERT_FALSE(postponed.empty());
  for (const char* text :
       {"data{x}", "header, data[rows 1:3]", "data[columns ::2]", "data{x}[columns 1999]"}) {
    const detail::ProjectionPlan plan(type, type.closed(type.parse_selection(text).value()));
    detail::Projection expected, projection;
    ASSERT_TRUE(expected.project(whole.state(), plan));
    std::vector<std::byte> memory(projection.bytes_most(source.state(), plan));
    ASSERT_TRUE(projection.project(source.state(), plan, memory, &postponed));
    EXPECT_EQ(test::gathered(projection), test::gathered(expected)) << text;
  }

  postponed.make(50'000);  // now the first row and some bytes of the second row are in the body
  const auto is_possible = [&](const char* text) {
    const detail::ProjectionPlan plan(type, type.closed(type.parse_selection(text).value()));
    detail::Projection projection;
    return projection.project(source.state(), plan, {}, &postponed);
  };
  EXPECT_TRUE(is_possible("data{x}[rows :1]"));
  EXPECT_TRUE(is_possible("data{x}[rows 2]"));
  EXPECT_FALSE(is_possible("data{x}"));
}

}  // namespace
}  // namespace sft
