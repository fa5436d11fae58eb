// A struct is copied in one piece if its encoding in CDR has no padding at any offset.
#include <gtest/gtest.h>

#include <geometry_msgs/msg/PoseWithCovariance.hpp>
#include <nav_msgs/msg/Odometry.hpp>
#include <proof.hpp>
#include <torture_base.hpp>

#include "sft/detail/walk.h"
#include "tests/support/encoded.h"

namespace sft {
namespace {

using namespace detail;

template <class T>
constexpr const StructType& type = TypeTable<T>::type;

TEST(PackingTest, PrimitivesAndArraysOfOneSizeArePacked) {
  EXPECT_EQ(type<geometry_msgs::msg::Point>.packed_bytes, 24U);
  EXPECT_EQ(type<builtin_interfaces::msg::Time>.packed_bytes, 8U);
  EXPECT_EQ(type<builtin_interfaces::msg::Time>.alignment, 4U);
  EXPECT_TRUE(type<geometry_msgs::msg::Point>.is_packed_in_memory);
}

TEST(PackingTest, StructsOfPackedStructsArePacked) {
  EXPECT_EQ(type<geometry_msgs::msg::PoseWithCovariance>.packed_bytes, (7U + 36U) * 8U);
  EXPECT_TRUE(type<geometry_msgs::msg::PoseWithCovariance>.is_packed_in_memory);
}

TEST(PackingTest, StringsSequencesAndBooleansHaveToBeLookedAt) {
  EXPECT_EQ(type<std_msgs::msg::Header>.packed_bytes, 0U);
  EXPECT_EQ(type<proof::Chunk>.packed_bytes, 0U);
  EXPECT_EQ(type<nav_msgs::msg::Odometry>.packed_bytes, 0U);
  EXPECT_EQ(type<nav_msgs::msg::Odometry>.alignment, 8U);
}

TEST(PackingTest, PaddingWithinIsNotPacked) {
  EXPECT_EQ(type<proof::Pair>.packed_bytes, 0U);
  EXPECT_EQ(type<proof::Pair>.alignment, 8U);
}

constexpr StructType struct_of(std::span<const Member> members) { return {"", members}; }

// {uint32, uint32, double} has padding if it begins 4 bytes after a multiple of 8, and none if it begins at
// a multiple of 8.
TEST(PackingTest, PaddingThatDependsOnWhatIsInFrontIsNotPacked) {
  const Member members[] = {member<std::uint32_t>("a", Kind::uint32, 0),
                            member<std::uint32_t>("b", Kind::uint32, 4),
                            member<double>("c", Kind::float64, 8)};
  EXPECT_EQ(struct_of(members).packed_bytes, 0U);
}

// {double, octet} has padding after each element of an array except the last.
TEST(PackingTest, PaddingBehindIsNotPacked) {
  const Member members[] = {member<double>("a", Kind::float64, 0), member<std::uint8_t>("b", Kind::octet, 8)};
  EXPECT_EQ(struct_of(members).packed_bytes, 0U);
}

TEST(PackingTest, OtherPlacesInMemoryAreNoticed) {
  const Member members[] = {member<double>("a", Kind::float64, 0), member<float>("b", Kind::float32, 12),
                            member<float>("c", Kind::float32, 8)};
  EXPECT_EQ(struct_of(members).packed_bytes, 16U);
  EXPECT_FALSE(struct_of(members).is_packed_in_memory);
}

// A hostile description may describe 2^64 + 1 bytes, which must not count as one byte.
TEST(PackingTest, SizesThatOverflowAreNotPacked) {
  const Member gigabytes[] = {{.name = "a", .kind = Kind::octet, .shape = Shape::array, .count = 1U << 31}};
  const StructType inner = struct_of(gigabytes);
  ASSERT_EQ(inner.packed_bytes, 1U << 31);
  const Member many{
      .name = "b", .kind = Kind::structure, .shape = Shape::array, .count = 1U << 31, .type = &inner};
  const Member members[] = {many, many, many, many, {.name = "c", .kind = Kind::octet}};
  EXPECT_EQ(struct_of(members).packed_bytes, 0U);
}

TEST(PackingTest, ManyElementsAreSkippedAtOnce) {
  using torture_base::Point;
  static_assert(TypeTable<Point>::type.packed_bytes == 8);
  const Member members[] = {member<std::vector<Point>>("points", Kind::structure, 0)};
  const StructType points = struct_of(members);
  const FieldMask full = FieldMask::full(points.leaves);
  const std::vector<Point> value(1000);
  const test::Encoded encoded(points, &value, full);
  EXPECT_EQ(encoded.state().body_bytes, 8004U);
  EXPECT_EQ(skip_elements(encoded.state(), TypeTable<Point>::type, 1, 1000, 4), 8004U);
  EXPECT_EQ(skip_elements(encoded.state(), TypeTable<Point>::type, 1, 1001, 4), no_offset);
  EXPECT_EQ(skip_elements(encoded.state(), TypeTable<Point>::type, 1, 0xffff'ffff, 4), no_offset);
}

}  // namespace
}  // namespace sft
