// A number that is written as text is read back as the same number, in any rounding mode.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cfenv>
#include <cmath>
#include <geometry_msgs/msg/Point.hpp>
#include <geometry_msgs/msg/Point32.hpp>
#include <sensor_msgs/msg/BatteryState.hpp>
#include <span>

#include "sft/json.h"
#include "sft/type_support.h"
#include "sft/yaml.h"
#include "tests/support/encoded.h"
#include "tests/support/test_seed.h"

namespace sft {
namespace {

using namespace detail;

using geometry_msgs::msg::Point;
using geometry_msgs::msg::Point32;
using test::Encoded;

class RoundingTest : public test::RandomTest, public testing::WithParamInterface<int> {
 protected:
  RoundingTest() { std::fesetround(GetParam()); }
  ~RoundingTest() override { std::fesetround(FE_TONEAREST); }

  double any_number() {
    for (;;) {
      const auto number = std::bit_cast<double>(random());
      if (std::isfinite(number)) return number;
    }
  }
  float any_single_number() {
    for (;;) {
      const auto number = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
      if (std::isfinite(number)) return number;
    }
  }
  template <class T, class ToText>
  static void expect_read_back(const T& message, const ToText& to_text) {
    const Encoded encoded(message);
    const std::string text = to_text(DynamicView(encoded.state(), TypeTable<T>::type));
    const auto json = json_from_yaml(TypeTable<T>::type, text);
    ASSERT_TRUE(json) << json.error().message;
    const auto read = cdr_from_json(TypeTable<T>::type, *json, {});
    ASSERT_TRUE(read) << read.error().message;
    constexpr std::size_t encapsulation = 4;
    EXPECT_TRUE(std::ranges::equal(std::span(*read).subspan(encapsulation), encoded.bytes())) << text;
  }
  template <class T>
  static void expect_read_back(const T& message) {
    expect_read_back(message, [](const DynamicView& view) { return to_json(view, {}).value(); });
    expect_read_back(message, [](const DynamicView& view) { return to_yaml(view, {}).value(); });
    EXPECT_EQ(std::fegetround(), GetParam()) << "it is the program's";
  }
};

TEST_P(RoundingTest, JsonAndYamlAreReadBackAsWhatTheyWereWrittenFrom) {
  for (int i = 0; i < 300; ++i) {
    expect_read_back(Point{.x = any_number(), .y = any_number(), .z = any_number()});
    expect_read_back(Point32{.x = any_single_number(), .y = any_single_number(), .z = any_single_number()});
  }
}

TEST_P(RoundingTest, ASelectionIsReadBackAsWhatItWasWrittenFrom) {
  const auto& type = type_support<sensor_msgs::msg::BatteryState>();
  for (int i = 0; i < 300; ++i) {
    const std::string text =
        "voltage @ voltage > " + std::to_string(std::abs(std::remainder(any_number(), 1e6)));
    const auto here = type.parse_selection(text);
    ASSERT_TRUE(here) << here.error().message;
    std::fesetround(FE_TONEAREST);
    EXPECT_EQ(*here, *type.parse_selection(text)) << text;
    std::fesetround(GetParam());
  }
}

INSTANTIATE_TEST_SUITE_P(Modes, RoundingTest,
                         testing::Values(FE_TONEAREST, FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO));

}  // namespace
}  // namespace sft
