// Reading messages from YAML.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <geometry_msgs/msg/Point.hpp>
#include <locale>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <std_msgs/msg/Bool.hpp>
#include <std_msgs/msg/String.hpp>
#include <std_msgs/msg/UInt64.hpp>
#include <visualization_msgs/msg/MarkerArray.hpp>

#include "sft/json.h"
#include "sft/yaml.h"
#include "tests/support/encoded.h"
#include "tests/support/test_seed.h"

namespace sft {
namespace {

using namespace detail;

using sensor_msgs::msg::PointCloud2;
using test::Encoded;
using ::testing::HasSubstr;

template <class T>
Result<std::vector<std::byte>> payload_of(std::string_view yaml) {
  const FromJsonOptions options{.now = std::chrono::sys_time<std::chrono::nanoseconds>()};
  return json_from_yaml(TypeTable<T>::type, yaml).and_then([&](const std::string& json) {
    return cdr_from_json(TypeTable<T>::type, json, options);
  });
}

template <class T>
::testing::AssertionResult means(std::string_view yaml, const T& message) {
  const auto payload = payload_of<T>(yaml);
  if (!payload) return ::testing::AssertionFailure() << payload.error().message;
  const std::vector<std::byte> body(payload->begin() + 4, payload->end());
  if (body == Encoded(message).bytes()) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << json_from_yaml(TypeTable<T>::type, yaml).value();
}

template <class T>
std::string yaml_fault(std::string_view yaml) {
  const auto payload = payload_of<T>(yaml);
  return payload ? "" : payload.error().message;
}

TEST(FromYamlTest, BlocksFlowsAndJsonAreTheSameMessage) {
  PointCloud2 c;
  c.header.frame_id = "lidar";
  c.width = 3;
  c.fields.resize(2);
  c.fields[1].name = "y";
  c.data = {1, 255};
  for (const char* yaml : {
           "header:\n  frame_id: lidar\nwidth: 3\nfields:\n- {}\n- name: y  # as text\ndata: [1, 0xff]\n",
           "{header: {frame_id: lidar}, width: 3, fields: [{}, {name: y}], data: [1, 255]}",
           R"({"header": {"frame_id": "lidar"}, "width": 3, "fields": [{}, {"name": "y"}], "data": "Af8="})",
           "--- {width: 3, header: {frame_id: 'lidar'}, data: Af8=, fields: [{}, {name: 'y'}]}",
       }) {
    EXPECT_TRUE(means(yaml, c)) << yaml;
  }
}

TEST(FromYamlTest, AScalarIsWhatItsFieldNeeds) {
  EXPECT_TRUE(means("data: 7", std_msgs::msg::String{.data = "7"}));
  EXPECT_TRUE(means("data: yes", std_msgs::msg::String{.data = "yes"}));
  EXPECT_TRUE(means("data: yes", std_msgs::msg::Bool{.data = true}));
  EXPECT_TRUE(means("data: 18446744073709551615", std_msgs::msg::UInt64{.data = 18446744073709551615U}));
  const geometry_msgs::msg::Point point{.x = 1, .y = -.5, .z = -HUGE_VAL};
  EXPECT_TRUE(means("{x: 1, y: -.5, z: -.inf}", point));
}

/// A locale's punctuation of numbers as in much of Europe: 1.000.000,5.
class Punctuation : public std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

TEST(FromYamlTest, NumbersAreTheSameWhateverLocaleTheProgramHasChosen) {
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new Punctuation));
  const geometry_msgs::msg::Point point{.x = 1.5, .y = -1'000'000.25, .z = 2e-3};
  EXPECT_TRUE(means("{x: 1.5, y: -1000000.25, z: 2e-3}", point));
  const Encoded encoded(point);
  const DynamicView view(encoded.state(), TypeTable<geometry_msgs::msg::Point>::type);
  EXPECT_TRUE(means(to_yaml(view).value(), point));
  EXPECT_TRUE(means(to_json(view).value(), point));
  EXPECT_TRUE(means("data: 1000000", std_msgs::msg::UInt64{.data = 1'000'000}));
  EXPECT_EQ(yaml_fault<std_msgs::msg::UInt64>("data: 1.5"),
            "'data' is 1.5; an integer from 0 to 18446744073709551615 was expected");
  std::locale::global(before);
}

TEST(FromYamlTest, NumbersHaveTheFormsOfYaml) {
  const auto is_number = [](const char* text, std::uint64_t value) {
    return means(std::string("data: ") + text, std_msgs::msg::UInt64{.data = value});
  };
  EXPECT_TRUE(is_number("+7", 7));
  EXPECT_TRUE(is_number("0xFf", 255));
  EXPECT_TRUE(is_number("010", 8));
  EXPECT_TRUE(is_number("0", 0));
  for (const char* text : {"0x", "+-7", "--7", "7-", "0x-7", "1e400", "+", "-"})
    EXPECT_NE(yaml_fault<std_msgs::msg::UInt64>(std::string("data: ") + text), "") << text;
}

TEST(FromYamlTest, ANumberHasManyFormsButATextOrABooleanIsNone) {
  for (const char* text : {"50", "5e1", "50.0", "+50", "50."})
    EXPECT_TRUE(means(std::string("x: ") + text, geometry_msgs::msg::Point{.x = 50})) << text;
  for (const char* text : {"'50'", "\"50\"", "true", "fifty", "[50]", ""})
    EXPECT_THAT(yaml_fault<geometry_msgs::msg::Point>(std::string("x: ") + text), HasSubstr("'x'")) << text;
  for (const char* text : {"50.5", "'50'", "true", "-1"})
    EXPECT_THAT(yaml_fault<std_msgs::msg::UInt64>(std::string("data: ") + text), HasSubstr("'data'")) << text;
}

TEST(FromYamlTest, WhatIsNotOfTheTypeIsNamedByItsPath) {
  EXPECT_EQ(yaml_fault<PointCloud2>("fields: [{}, {offset: -1}]"),
            "'fields[1].offset' is -1; an integer from 0 to 4294967295 was expected");
  EXPECT_EQ(yaml_fault<PointCloud2>("width: '7'"),
            "'width' is \"7\"; an integer from 0 to 4294967295 was expected");
  EXPECT_EQ(yaml_fault<PointCloud2>("widht: 7"),
            "'widht' is no member of sensor_msgs::msg::PointCloud2; did you mean 'width'?");
  EXPECT_EQ(yaml_fault<PointCloud2>("header:\n  frame_id:\n"),
            "'header.frame_id' is null; a string was expected");
  EXPECT_EQ(yaml_fault<PointCloud2>("fields: x"), "'fields' is \"x\"; an array was expected");
  EXPECT_EQ(yaml_fault<PointCloud2>("width: [1]"),
            "'width' is an array; an integer from 0 to 4294967295 was expected");
  EXPECT_EQ(yaml_fault<PointCloud2>(""),
            "the message is null; an object with the members of sensor_msgs::msg::PointCloud2 was expected");
}

TEST(FromYamlTest, WhatIsNoYamlIsNamedByItsPlace) {
  EXPECT_THAT(yaml_fault<PointCloud2>("header:\n  frame_id: [\n"), HasSubstr("this is no YAML in line "));
  EXPECT_EQ(yaml_fault<PointCloud2>("width: 1\nheight: 2\nwidth: 3\n"),
            "'width' stands twice in one mapping, the second time in line 3, column 1");
  EXPECT_EQ(yaml_fault<PointCloud2>("width: 1\n---\nwidth: 2\n"),
            "there is more behind the first document of YAML; one message was expected");
  EXPECT_NE(yaml_fault<PointCloud2>(",width: 1"), "");
}

TEST(FromYamlTest, AliasesThatMakeMuchOfLittleAreRefused) {
  EXPECT_TRUE(means("fields: [&f {name: x}, *f]", [] {
    PointCloud2 c;
    c.fields.resize(2);
    c.fields[0].name = c.fields[1].name = "x";
    return c;
  }()));
  std::string yaml = "{markers: [&m {points: &p [";
  for (int i = 0; i < 500; ++i) yaml += "{x: 1}, ";
  yaml += "], colors: [], text: a}, ";
  for (int i = 0; i < 5000; ++i) yaml += "*m, ";
  EXPECT_THAT(yaml_fault<visualization_msgs::msg::MarkerArray>(yaml + "]}"),
              HasSubstr("aliases multiply the values of the text too often"));
}

TEST(FromYamlTest, DeepNestingIsRefusedAndNoHarm) {
  const std::string deep(100'000, '[');
  EXPECT_NE(yaml_fault<PointCloud2>("width: " + deep), "");
  EXPECT_NE(yaml_fault<PointCloud2>("width: " + std::string(100'000, '{')), "");
}

class DamagedYaml : public test::RandomTest {};

TEST_F(DamagedYaml, IsAnErrorOrAWholeMessage) {
  const std::string good =
      "header: {stamp: {sec: 7, nanosec: 0}, frame_id: \"a\\x41\"}\nheight: !!int 1\nfields:\n- &f\n  name: "
      "|\n"
      "    x\n  offset: 0x10\n- *f\n- {name: 'y', ? count : 1}\ndata: [1, 2, 255]\nis_dense: true # yes\n";
  ASSERT_TRUE(payload_of<PointCloud2>(good)) << yaml_fault<PointCloud2>(good);
  const std::string_view alphabet = "{}[]:,-&*!|>'\"\n \t#?%@\\\x7f\xff~a0<.";
  const std::uint64_t rounds = test::test_rounds(5000);
  std::uint64_t errors = 0;
  for (std::uint64_t round = 0; round < rounds; ++round) {
    std::string text = good;
    for (std::uint64_t damage = 1 + random() % 4; damage > 0; --damage) {
      const std::size_t at = random() % text.size();
      const char c = alphabet[random() % alphabet.size()];
      switch (random() % 3) {
        case 0:
          text[at] = c;
          break;
        case 1:
          text.insert(at, random() % 8 + 1, c);
          break;
        default:
          text.erase(at, random() % 8 + 1);
      }
    }
    const auto payload = payload_of<PointCloud2>(text);
    errors += payload ? 0 : 1;
    EXPECT_TRUE(payload || !payload.error().message.empty()) << text;
  }
  EXPECT_GT(errors, rounds / 4);
  EXPECT_LT(errors, rounds);
}

}  // namespace
}  // namespace sft
