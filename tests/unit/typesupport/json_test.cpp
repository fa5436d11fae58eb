// Samples as JSON. dynamic_law_test.cpp checks that the JSON text has every value.
#include "sft/json.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <torture.hpp>

#include "tests/support/encoded.h"

namespace sft {
namespace {

using namespace detail;

using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;
using P = torture::Primitives::Field;
using test::Encoded;

template <class T>
std::string json_of(const T& value, const Mask<T>& mask = all<T>, const JsonOptions& options = {}) {
  const Encoded encoded(value, mask);
  return to_json(DynamicView(encoded.state(), TypeTable<T>::type), options).value();
}

PointCloud2 with_data(std::vector<std::uint8_t> data) {
  PointCloud2 c;
  c.data = std::move(data);
  return c;
}

TEST(JsonTest, KeepsTheOrderOfMembersAndLeavesOutWhatIsAbsent) {
  PointCloud2 c;
  c.header.frame_id = "lidar";
  c.width = 3;
  c.fields.resize(2);
  EXPECT_EQ(json_of(c, F::width | F::header.frame_id | F::fields.each.offset),
            R"({"header":{"frame_id":"lidar"},"width":3,"fields":[{"offset":0},{"offset":0}]})");
  EXPECT_EQ(json_of<PointCloud2>(c, F::fields.size), R"({"fields.size":2})");
  EXPECT_EQ(json_of(c, Mask<PointCloud2>{}), "{}");
  EXPECT_EQ(json_of<PointCloud2>(c, F::width, {.indent = 2}), "{\n  \"width\": 3\n}");
}

TEST(JsonTest, BytesAreBase64OrNumbers) {
  const auto base64 = [](std::vector<std::uint8_t> bytes) {
    return json_of<PointCloud2>(with_data(std::move(bytes)), F::data);
  };
  EXPECT_EQ(base64({}), R"({"data":""})");
  EXPECT_EQ(base64({'f'}), R"({"data":"Zg=="})");
  EXPECT_EQ(base64({'f', 'o'}), R"({"data":"Zm8="})");
  EXPECT_EQ(base64({'f', 'o', 'o'}), R"({"data":"Zm9v"})");
  EXPECT_EQ(base64({0xff, 0xfe, 0xfd, 0}), R"({"data":"//79AA=="})");
  EXPECT_EQ(json_of<PointCloud2>(with_data({1, 255}), F::data, {.bytes_as_base64 = false}),
            R"({"data":[1,255]})");
}

TEST(JsonTest, SaysHowManyElementsAreBeyondTheLimit) {
  EXPECT_EQ(
      json_of<PointCloud2>(with_data({1, 2, 3, 4}), F::data, {.elements_max = 2, .bytes_as_base64 = false}),
      R"({"data":[1,2,"... 2 more"]})");
}

TEST(JsonTest, NumbersThatJsonDoesNotKnowAreStrings) {
  torture::Primitives p;
  p.a_float = NAN;
  p.a_double = -INFINITY;
  EXPECT_EQ(json_of(p, P::a_float | P::a_double), R"({"a_float":"NaN","a_double":"-Infinity"})");
}

TEST(JsonTest, IntegersKeepAllTheirDigitsAndFloatsHaveNoMoreThanTheyNeed) {
  torture::Primitives p;
  p.a_llong = INT64_MIN;
  p.a_ullong = UINT64_MAX;
  p.a_float = 0.1F;
  EXPECT_EQ(json_of(p, P::a_llong | P::a_ullong | P::a_float),
            R"({"a_llong":-9223372036854775808,"a_ullong":18446744073709551615,"a_float":0.1})");
}

TEST(JsonTest, TextThatIsNotUtf8IsReplaced) {
  torture::Primitives p;
  p.a_string =
      "a\xff"
      "b\n";
  p.a_char = '\xe4';
  EXPECT_EQ(json_of(p, P::a_string | P::a_char),
            "{\"a_char\":\"\xef\xbf\xbd\",\"a_string\":\"a\xef\xbf\xbd"
            "b\\n\"}");
}

TEST(JsonTest, EnumerationsAreTheirNamesAndNumbersWhereTheyHaveNone) {
  torture::Sequences s;
  s.colors = {torture::Color::GREEN, static_cast<torture::Color>(-5)};
  EXPECT_EQ(json_of<torture::Sequences>(s, torture::Sequences::Field::colors), R"({"colors":["GREEN",-5]})");
}

TEST(JsonTest, WhatIsMalformedOrTooLongIsAnError) {
  Encoded encoded(with_data({1, 2, 3}));
  const DynamicView view(encoded.state(), TypeTable<PointCloud2>::type);
  EXPECT_EQ(to_json(view, {.output_bytes_max = 50}).error().code, Errc::limit_exceeded);
  const std::uint32_t length = 1000;
  std::memcpy(encoded.body() + encoded.index()[9], &length, sizeof length);
  EXPECT_EQ(to_json(view).error().code, Errc::malformed);
}

TEST(JsonTest, OfPlainTextsIsNeverLongerThanItMayBe) {
  torture::Sequences s;
  s.texts.assign(100, "abc");
  const Encoded encoded(s, Mask<torture::Sequences>(torture::Sequences::Field::texts));
  const DynamicView view(encoded.state(), TypeTable<torture::Sequences>::type);
  bool some_is_refused = false;
  for (std::size_t most = 0; most < 1000; ++most) {
    const Result<std::string> text = to_json(view, {.output_bytes_max = most});
    some_is_refused |= !text;
    if (text) {
      EXPECT_LE(text->size(), most);
    }
  }
  EXPECT_TRUE(some_is_refused);
  EXPECT_TRUE(to_json(view, {.output_bytes_max = 1000}));
}

// ---- from JSON ----

template <class T>
std::string json_fault(std::string_view json, std::size_t bytes_max = 1000) {
  const auto payload = cdr_from_json(TypeTable<T>::type, json, {.bytes_max = bytes_max});
  return payload ? "" : payload.error().message;
}

TEST(FromJsonTest, MembersComeInAnyOrderAndWhatIsLeftOutIsZeroOrEmpty) {
  PointCloud2 c;
  c.header.frame_id = "lidar";
  c.width = 3;
  c.fields.resize(2);
  c.fields[1].name = "y";
  c.data = {'f', 'o'};
  const std::vector<std::byte> expected = Encoded(c).bytes();
  for (const char* data : {R"("Zm8=")", "[102, 111]"}) {
    const auto payload = cdr_from_json(
        TypeTable<PointCloud2>::type, std::string(R"({"width": 3, "fields": [{}, {"name": "y"}], "data": )") +
                                          data + R"(, "header": {"frame_id": "lidar"}})");
    ASSERT_TRUE(payload) << payload.error().message;
    EXPECT_EQ(std::vector(payload->begin() + 4, payload->end()), expected);
  }
}

TEST(FromJsonTest, WhatIsNotOfTheTypeIsNamedByItsPathWithWhatWasExpected) {
  EXPECT_EQ(json_fault<PointCloud2>(R"({"fields": [{}, {"offset": -1}]})"),
            "'fields[1].offset' is -1; an integer from 0 to 4294967295 was expected");
  EXPECT_EQ(json_fault<PointCloud2>(R"({"header": {"frame_id": 7}})"),
            "'header.frame_id' is 7; a string was expected");
  EXPECT_EQ(json_fault<PointCloud2>(R"({"is_dense": 1})"), "'is_dense' is 1; true or false was expected");
  EXPECT_EQ(json_fault<PointCloud2>(R"({"header": []})"),
            "'header' is an array; an object with the members of std_msgs::msg::Header was expected");
  EXPECT_EQ(json_fault<PointCloud2>(R"({"fields": {}})"), "'fields' is an object; an array was expected");
  EXPECT_EQ(json_fault<PointCloud2>(R"({"data": "Zm8"})"), "'data' is no base64 (RFC 4648, padded)");
  EXPECT_EQ(json_fault<PointCloud2>(R"({"data": [256]})"),
            "'data[0]' is 256; an integer from 0 to 255 was expected");
  EXPECT_EQ(json_fault<PointCloud2>("7"),
            "the message is 7; an object with the members of sensor_msgs::msg::PointCloud2 was expected");
  EXPECT_EQ(
      json_fault<torture::Primitives>(R"({"a_float": "much"})"),
      R"('a_float' is "much"; a number that a float holds, "NaN", "Infinity" or "-Infinity" was expected)");
  EXPECT_EQ(json_fault<torture::Primitives>(R"({"a_float": 1e300})").substr(0, 18), "'a_float' is 1e+30");
  EXPECT_EQ(json_fault<torture::Primitives>(R"({"a_char": "ab"})"),
            R"('a_char' is "ab"; a string of one ASCII character was expected)");
  EXPECT_NE(
      json_fault<torture::Sequences>(R"({"colors": ["MAUVE"]})").find("'colors[0]' is \"MAUVE\"; one of "),
      std::string::npos);
}

TEST(FromJsonTest, AMemberThatTheTypeDoesNotHaveIsAnErrorThatNamesTheNearest) {
  EXPECT_EQ(json_fault<PointCloud2>(R"({"header": {"frameid": "x"}})"),
            "'header.frameid' is no member of std_msgs::msg::Header; did you mean 'frame_id'?");
}

TEST(FromJsonTest, TextsWithANulAndTextsThatAreNoJsonAreErrors) {
  EXPECT_EQ(json_fault<PointCloud2>(R"({"header": {"frame_id": "a\u0000"}})"),
            "'header.frame_id' has a NUL in it; a string ends at its first one");
  EXPECT_EQ(json_fault<PointCloud2>(R"({"width": )"), "the text is no JSON: the error is at byte 11");
  EXPECT_EQ(json_fault<PointCloud2>(""), "the text is no JSON: the error is at byte 1");
}

TEST(FromJsonTest, AMessageThatIsTooLargeIsRefusedWhereItBecomesThat) {
  EXPECT_EQ(json_fault<PointCloud2>(R"({"data": [1, 2, 3]})", 45),
            "'data[1]' is where the message has more than 45 bytes");
}

TEST(FromJsonTest, AStampMayBeNowAndAHeaderAuto) {
  using namespace std::chrono_literals;
  PointCloud2 c;
  c.header.stamp.sec = -3;
  c.header.stamp.nanosec = 250'000'000;
  const std::vector<std::byte> expected = Encoded(c).bytes();
  const FromJsonOptions options{.now = std::chrono::sys_time<std::chrono::nanoseconds>(-2750ms)};
  for (const char* json : {R"({"header": "auto"})", R"({"header": {"stamp": "now"}})"}) {
    const auto payload = cdr_from_json(TypeTable<PointCloud2>::type, json, options);
    ASSERT_TRUE(payload) << payload.error().message;
    EXPECT_EQ(std::vector(payload->begin() + 4, payload->end()), expected) << json;
  }
  const auto wrong = cdr_from_json(TypeTable<PointCloud2>::type, R"({"header": {"stamp": "auto"}})", options);
  EXPECT_EQ(wrong.error().message,
            "'header.stamp' is \"auto\"; an object with the members of builtin_interfaces::msg::Time, or "
            "\"now\", was expected");
}

TEST(FromJsonTest, WithoutAClockNowIsNoStamp) {
  EXPECT_EQ(json_fault<PointCloud2>(R"({"header": {"stamp": "now"}})"),
            "'header.stamp' is \"now\"; an object with the members of builtin_interfaces::msg::Time was "
            "expected");
}

}  // namespace
}  // namespace sft
