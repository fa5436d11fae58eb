// Sets of fields at compile time, and their combination with types at run time.
#include "sft/mask.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <ranges>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <vector>
#include <views.hpp>

#include "sft/type_support.h"

namespace sft {
namespace {

using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;
using views::Wider;
using W = Wider::Field;

static_assert(Mask<Wider>::leaves > 200);
static_assert(std::ranges::forward_range<Mask<PointCloud2>>);

TEST(MaskTest, NamesAndMasksCombineAsSetsDo) {
  static_assert((F::header & F::header.stamp) == F::header.stamp);
  static_assert((F::header - F::header.stamp) == F::header.frame_id);
  static_assert(((F::width | F::data) ^ (F::data | F::height)) == (F::height | F::width));
  static_assert(~F::data == all<PointCloud2> - F::data);
  static_assert((F::width & F::height) == Mask<PointCloud2>{});
  static_assert(F::fields == (F::fields.size | F::fields.each));
  static_assert(F::width != F::height);
}

TEST(MaskTest, OfManyLeavesToo) {
  static_assert((W::first | W::second) == all<Wider>);
  static_assert(~W::first == W::second);
  static_assert((W::second - W::second.d9.m7).size() == Mask(W::second).size() - 1);
  static_assert(Mask(W::second).contains(W::second.d11.m0) && !Mask(W::second).contains(W::first.d11.m0));
  static_assert((W::first.d0.m0 ^ W::second.d11.m11).size() == 2);
}

TEST(MaskTest, KnowsWhatItContains) {
  constexpr Mask header(F::header);
  static_assert(header.contains(F::header.stamp.sec) && !header.contains(F::header | F::data));
  static_assert(header.intersects(F::header.frame_id | F::data) && !header.intersects(F::data));
  static_assert(Mask<PointCloud2>{}.empty() && !header.empty());
  static_assert(header.contains(Mask<PointCloud2>{}));
}

template <class T>
std::vector<std::size_t> leaves_of(const Mask<T>& mask) {
  std::vector<std::size_t> leaves;
  for (const std::size_t leaf : mask) leaves.push_back(leaf);
  return leaves;
}

TEST(MaskTest, IsARangeOfTheNumbersOfItsLeaves) {
  EXPECT_EQ(leaves_of(Mask(F::header)), (std::vector<std::size_t>{0, 1, 2}));
  EXPECT_EQ(leaves_of<PointCloud2>({}), std::vector<std::size_t>{});
  EXPECT_TRUE(std::ranges::equal(all<Wider>, std::views::iota(std::size_t{0}, Mask<Wider>::leaves)));
  EXPECT_EQ(*Mask(W::second).begin(), Mask(W::first).size());
  static_assert(std::ranges::distance(Mask(F::fields)) == 5);
}

TEST(MaskTest, PrintsAsTheShortestListOfNames) {
  EXPECT_EQ(to_string(F::header | F::data), "header, data");
  EXPECT_EQ(to_string(F::header.stamp), "header.stamp");
  EXPECT_EQ(to_string(all<PointCloud2>), "*");
  EXPECT_EQ(to_string(W::second | W::first.d3.m2), "first.d3.m2, second");
  EXPECT_EQ(to_string<PointCloud2>(FieldMask(F::fields.each)), "fields[]");
}

TEST(MaskTest, OfATypeAtRunTimeIsComparedWithNames) {
  const FieldMask received = type_support<PointCloud2>().parse_mask("header, width").value();
  EXPECT_EQ(received, FieldMask(F::header | F::width));
  EXPECT_TRUE(received.contains(F::header.stamp));
  EXPECT_FALSE(received.contains(F::header | F::data));
  EXPECT_TRUE(received.intersects(F::header | F::data));
}

TEST(TypeSupportOfATypeTest, NamesLeavesAndReadsMasks) {
  const TypeSupport& support = type_support<PointCloud2>();
  EXPECT_EQ(&support, &type_support<PointCloud2>());
  std::vector<std::string> names;
  for (const std::size_t leaf : F::header | F::height) names.push_back(support.path(leaf));
  EXPECT_EQ(names, (std::vector<std::string>{"header.stamp.sec", "header.stamp.nanosec", "header.frame_id",
                                             "height"}));
  EXPECT_EQ(type_support<Wider>().parse_mask("secnd.d3").error().message,
            "views::Wider has no field 'secnd.d3'; did you mean 'second.d3'?");
}

TEST(TypeSupportOfATypeTest, TextOfAnyMaskOfManyLeavesReadsBackAsTheSame) {
  const TypeSupport& support = type_support<Wider>();
  const FieldMask every_third = [&] {
    FieldMask mask = support.none();
    for (std::size_t leaf = 0; leaf < support.leaves(); leaf += 3) mask.insert(leaf);
    return mask;
  }();
  for (const FieldMask& mask : {every_third, ~every_third, FieldMask(W::second), support.none()})
    EXPECT_EQ(support.parse_mask(support.format_mask(mask)).value(), mask);
}

}  // namespace
}  // namespace sft
