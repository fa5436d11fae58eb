// Includes headers of several IDL files that ROS 2's tool made from .msg files. These IDL files have no
// include guards.
#include <gtest/gtest.h>

#include <unguarded/Top.hpp>

#include <type_traits>

namespace {

using unguarded::msg::Base;
using unguarded::msg::Top;

TEST(UnguardedFiles, MayBeIncludedByDifferentWays) {
  static_assert(std::is_same_v<decltype(Top::base), Base>);
  static_assert(std::is_same_v<decltype(unguarded::msg::Left::bases), std::array<Base, 2>>);
  static_assert(std::is_same_v<decltype(unguarded::msg::Right::bases), std::array<Base, 2>>);
}

TEST(UnguardedFiles, MayAllDeclareTheSameAliases) {
  static_assert(std::is_same_v<unguarded::msg::double__3, std::array<double, 3>>);
  static_assert(std::is_same_v<decltype(unguarded::msg::Left::numbers), unguarded::msg::double__3>);
}

TEST(UnguardedFiles, MayHaveNamesThatDifferInCaseOnly) {
  static_assert(Base::INT8 == 1);
  EXPECT_EQ(Base{}.value, -2);
  EXPECT_EQ(sft::detail::TypeTable<Base>::members[0].unit, "m");
}

}  // namespace
