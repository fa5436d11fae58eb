// The numbering, paths and hashes of types, and the text form of masks.
#include "sft/type_support.h"
#include "sft/detail/type_shape.h"

#include <gtest/gtest.h>

#include <nav_msgs/msg/Odometry.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>

namespace sft {
namespace {

using namespace detail;

using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;

const TypeSupport& cloud_type() {
  static const TypeSupport type(TypeTable<PointCloud2>::type);
  return type;
}

TEST(TypeSupportTest, LeavesAreNumberedDepthFirstAndALengthIsALeafOfItsOwn) {
  ASSERT_EQ(cloud_type().leaves(), 15U);
  EXPECT_EQ(cloud_type().path(0), "header.stamp.sec");
  EXPECT_EQ(cloud_type().path(5), "fields.size");
  EXPECT_EQ(cloud_type().path(6), "fields[].name");
  EXPECT_EQ(cloud_type().path(14), "is_dense");
  EXPECT_EQ(cloud_type().index_slots(), 11U);  // the leaves of `fields` share one slot
}

TEST(TypeSupportTest, TheNamesOfGeneratedCodeAreThoseOfThePaths) {
  EXPECT_EQ(*cloud_type().find("header.stamp"), FieldMask(Mask<PointCloud2>(F::header.stamp)));
  EXPECT_EQ(*cloud_type().find("fields"), FieldMask(Mask<PointCloud2>(F::fields)));
  EXPECT_EQ(*cloud_type().find("fields.size"), FieldMask(Mask<PointCloud2>(F::fields.size)));
  EXPECT_EQ(*cloud_type().find("fields[].name"), FieldMask(Mask<PointCloud2>(F::fields.each.name)));
  EXPECT_EQ(*cloud_type().find("data"), FieldMask(Mask<PointCloud2>(F::data)));
}

TEST(TypeSupportTest, AnUnknownFieldIsAnErrorThatNamesTheNearest) {
  const auto result = cloud_type().find("heigth");
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, Errc::unknown_field);
  EXPECT_EQ(result.error().message,
            "sensor_msgs::msg::PointCloud2 has no field 'heigth'; did you mean 'height'?");
}

TEST(TypeSupportTest, MasksAreReadFromTextAndWrittenAsTheShortestList) {
  const auto mask = cloud_type().parse_mask("  header,height fields[].name ");
  ASSERT_TRUE(mask);
  EXPECT_EQ(cloud_type().format_mask(*mask), "header, height, fields[].name");
  EXPECT_EQ(cloud_type().format_mask(*cloud_type().parse_mask("*")), "*");
  EXPECT_EQ(cloud_type().format_mask(*cloud_type().parse_mask("")), "");
  EXPECT_FALSE(cloud_type().parse_mask("height, nothing"));
}

TEST(TypeSupportTest, WithLeavesOfElementsGoesTheLength) {
  EXPECT_EQ(cloud_type().closed(*cloud_type().find("fields[].name")),
            *cloud_type().parse_mask("fields[].name, fields.size"));
  EXPECT_EQ(cloud_type().closed(*cloud_type().find("height")), *cloud_type().find("height"));
}

TEST(TypeSupportTest, TypesOfAnotherStructureHaveAnotherHash) {
  EXPECT_EQ(cloud_type().hash(), TypeSupport(TypeTable<PointCloud2>::type).hash());
  EXPECT_NE(cloud_type().hash(), TypeSupport(TypeTable<nav_msgs::msg::Odometry>::type).hash());
  std::vector<Member> members(TypeTable<PointCloud2>::type.members.begin(),
                              TypeTable<PointCloud2>::type.members.end());
  members.back().kind = Kind::uint8;
  EXPECT_NE(structure_hash({"other", members}), cloud_type().hash());
}

TEST(TypeSupportTest, SetsOfFieldsComposeAtCompileTime) {
  static_assert((F::height | F::width) == (F::width | F::height));
  static_assert(~(F::height | F::width) != all<PointCloud2>);
  static_assert((F::header | F::data).contains(0) && !(F::header | F::data).contains(3));
  static_assert((~(F::height | F::width) | F::height | F::width) == all<PointCloud2>);
}

}  // namespace
}  // namespace sft
