// Printing samples as YAML.
#include "sft/yaml.h"
#include "sft/detail/type_description.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <torture.hpp>

#include "sft/dynamic_type.h"
#include "tests/support/encoded.h"

namespace sft {
namespace {

using namespace detail;

using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;
using test::Encoded;

template <class T>
std::string yaml_of(const T& value, const Mask<T>& mask = all<T>, const YamlOptions& options = {}) {
  const Encoded encoded(value, mask);
  const DynamicType type = DynamicType::parse(describe(TypeTable<T>::type)).value();
  return to_yaml(DynamicView(encoded.state(), type.type()), options).value();
}

PointCloud2 cloud_in_yaml() {
  PointCloud2 c;
  c.header.stamp.sec = 7;
  c.header.frame_id = "lidar";
  c.height = 2;
  c.fields.resize(2);
  c.fields[0].name = "x";
  c.fields[1].name = "y axis: right";
  c.fields[1].offset = 4;
  c.data = {0, 97, 194, 35};
  return c;
}

TEST(YamlTest, IsABlockPerStructAndAFlowPerSequenceOfNumbers) {
  EXPECT_EQ(yaml_of(cloud_in_yaml()),
            "header:\n"
            "  stamp:\n"
            "    sec: 7\n"
            "    nanosec: 0\n"
            "  frame_id: lidar\n"
            "height: 2\n"
            "width: 0\n"
            "fields:\n"
            "- name: x\n"
            "  offset: 0\n"
            "  datatype: 0\n"
            "  count: 0\n"
            "- name: \"y axis: right\"\n"
            "  offset: 4\n"
            "  datatype: 0\n"
            "  count: 0\n"
            "is_bigendian: false\n"
            "point_step: 0\n"
            "row_step: 0\n"
            "data: [0, 97, 194, 35]\n"
            "is_dense: false\n");
}

TEST(YamlTest, LeavesOutWhatIsNotInTheSample) {
  EXPECT_EQ(yaml_of(cloud_in_yaml(), F::header.frame_id | F::fields.each.name),
            "header:\n"
            "  frame_id: lidar\n"
            "fields:\n"
            "- name: x\n"
            "- name: \"y axis: right\"\n");
  EXPECT_EQ(yaml_of<PointCloud2>(cloud_in_yaml(), F::fields.size), "fields.size: 2\n");
  EXPECT_EQ(yaml_of(cloud_in_yaml(), Mask<PointCloud2>{}), "{}\n");
}

TEST(YamlTest, SaysHowManyElementsAreBeyondTheLimit) {
  EXPECT_EQ(yaml_of<PointCloud2>(cloud_in_yaml(), F::data, {.elements_max = 3}),
            "data: [0, 97, 194]  # ... 1 more\n");
  EXPECT_EQ(yaml_of<PointCloud2>(cloud_in_yaml(), F::fields.each.offset, {.elements_max = 1}),
            "fields:\n"
            "- offset: 0\n"
            "# ... 1 more\n");
}

TEST(YamlTest, EmptySequencesAreEmptyFlows) {
  EXPECT_EQ(yaml_of<PointCloud2>({}, F::fields | F::data), "fields: []\ndata: []\n");
}

TEST(YamlTest, PartsOfASampleCanBePrintedAlone) {
  const Encoded encoded(cloud_in_yaml());
  const DynamicView view(encoded.state(), TypeTable<PointCloud2>::type);
  EXPECT_EQ(to_yaml(view["header"]["stamp"]), "sec: 7\nnanosec: 0\n");
  EXPECT_EQ(to_yaml(view["height"]), "2\n");
  EXPECT_EQ(to_yaml(view["data"]), "data: [0, 97, 194, 35]\n");
  EXPECT_EQ(to_yaml(view["hight"]).error().code, Errc::unknown_field);
}

class TextInYaml : public ::testing::Test {
 protected:
  static std::string text(const std::string& text, std::size_t most = 4096) {
    PointCloud2 c;
    c.header.frame_id = text;
    std::string yaml = yaml_of<PointCloud2>(c, F::header.frame_id, {.text_bytes_max = most});
    yaml.erase(0, std::string("header:\n  frame_id: ").size());
    yaml.pop_back();
    return yaml;
  }
};

TEST_F(TextInYaml, IsQuotedWhereItWouldMeanSomethingElse) {
  EXPECT_EQ(text("base_link"), "base_link");
  EXPECT_EQ(text("/tf/base-link.2"), "/tf/base-link.2");
  EXPECT_EQ(text("two words"), "two words");
  for (const char* word : {"", "null", "True", "NO", "y", "1", "1.5", "-", ".inf", "a: b", "#a", "[a]", " a",
                           "a ", "0x10", "~", "*", "a#b", "%"}) {
    EXPECT_EQ(text(word), '"' + std::string(word) + '"');
  }
}

TEST_F(TextInYaml, IsUtf8AndEverythingElseIsEscaped) {
  EXPECT_EQ(text("\xc2\xb5m"), "\"\xc2\xb5m\"");
  EXPECT_EQ(text("a\nb\t\"\\"), R"("a\nb\t\"\\")");
  EXPECT_EQ(text("\x1b[2J"), R"("\x1b[2J")");
  EXPECT_EQ(text("\xff\xc3"), R"("\xff\xc3")");
  EXPECT_EQ(text("\xe2\x80\xae"), R"("\u202e")") << "it would turn the direction of writing";
  EXPECT_EQ(text("\xed\xa0\x80"), R"("\xed\xa0\x80")") << "a surrogate";
}

TEST_F(TextInYaml, IsCutBetweenCharacters) {
  EXPECT_EQ(text("abcdef", 4), "abcd  # ... 2 more");
  EXPECT_EQ(text("ab\xc2\xb5", 3), "ab  # ... 2 more");
}

TEST(YamlTest, FloatsHaveTheDigitsThatTheyNeedAndAreAlwaysFloats) {
  torture::Primitives p;
  const auto floats = [&](float f, double d) {
    p.a_float = f;
    p.a_double = d;
    return yaml_of(p, torture::Primitives::Field::a_float | torture::Primitives::Field::a_double);
  };
  EXPECT_EQ(floats(0.1F, 0.1), "a_float: 0.1\na_double: 0.1\n");
  EXPECT_EQ(floats(1, -0.0), "a_float: 1.0\na_double: -0.0\n");
  EXPECT_EQ(floats(1e20F, 1e300), "a_float: 1.0e+20\na_double: 1.0e+300\n");
  EXPECT_EQ(floats(NAN, -INFINITY), "a_float: .nan\na_double: -.inf\n");
}

TEST(YamlTest, EnumerationsCharactersAndUnitsAreReadable) {
  torture::Nested value;
  value.speed = 2.5;
  value.paint = static_cast<torture::Color>(3);
  value.primitives.a_char = 'c';
  value.sequences.colors = {torture::Color::RED, torture::Color::BLUE};
  value.sequences.texts = {"a", ""};
  value.sequences.flags = {1, 0};
  using N = torture::Nested::Field;
  EXPECT_EQ(yaml_of(value,
                    N::speed | N::primitives.a_char | N::paint | N::sequences.colors | N::sequences.texts |
                        N::sequences.flags,
                    {.units = true}),
            "header:\n"
            "  stamp:\n"
            "    sec: 0  # s\n"
            "    nanosec: 0  # ns\n"
            "  frame_id: \"\"\n"
            "speed: 2.5  # m/s\n"
            "primitives:\n"
            "  a_char: c\n"
            "sequences:\n"
            "  flags: [true, false]\n"
            "  texts:\n"
            "  - a\n"
            "  - \"\"\n"
            "  colors: [RED, BLUE]\n"
            "paint: 3\n");
}

TEST(YamlTest, WhatIsMalformedIsAnError) {
  Encoded encoded(cloud_in_yaml());
  const std::uint32_t length = 1000;
  std::memcpy(encoded.body() + encoded.index()[9], &length, sizeof length);
  const auto yaml = to_yaml(DynamicView(encoded.state(), TypeTable<PointCloud2>::type));
  ASSERT_FALSE(yaml);
  EXPECT_EQ(yaml.error().code, Errc::malformed);
  EXPECT_TRUE(encoded.state().is_malformed());
}

TEST(YamlTest, TheLengthOfTheWholeTextIsLimited) {
  const Encoded encoded(cloud_in_yaml());
  const auto yaml =
      to_yaml(DynamicView(encoded.state(), TypeTable<PointCloud2>::type), {.output_bytes_max = 50});
  ASSERT_FALSE(yaml);
  EXPECT_EQ(yaml.error().code, Errc::limit_exceeded);
}

TEST(YamlTest, TheLengthOfAListIsLimitedToo) {
  PointCloud2 cloud;
  cloud.data.resize(1000);
  const Encoded encoded(cloud);
  const DynamicView data = DynamicView(encoded.state(), TypeTable<PointCloud2>::type)["data"];
  EXPECT_TRUE(to_yaml(data));
  const auto yaml = to_yaml(data, {.output_bytes_max = 100});
  ASSERT_FALSE(yaml);
  EXPECT_EQ(yaml.error().code, Errc::limit_exceeded);
}

TEST(YamlTest, NamesThatYamlTakesForSomethingElseAreQuoted) {
  const Member members[] = {{.name = "on", .kind = Kind::uint8},
                            {.name = "Null", .kind = Kind::uint8},
                            {.name = "y", .kind = Kind::uint8}};
  const StructType type{"T", members};
  const FieldMask full = FieldMask::full(type.leaves);
  const std::byte body[]{std::byte{1}, std::byte{2}, std::byte{3}};
  const SampleState state{.body = body, .body_bytes = sizeof body, .mask = &full};
  EXPECT_EQ(to_yaml(DynamicView(state, type)).value(), "\"on\": 1\n\"Null\": 2\ny: 3\n");
}

}  // namespace
}  // namespace sft
