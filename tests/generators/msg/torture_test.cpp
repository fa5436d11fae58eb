// These tests check the code that is generated for the messages in interfaces/torture_msgs.
#include <gtest/gtest.h>

#include <default/msg/Class.hpp>
#include <limits>
#include <string>
#include <string_view>
#include <torture_msgs/msg/Collections.hpp>
#include <torture_msgs/msg/Deep.hpp>
#include <torture_msgs/msg/Literals.hpp>
#include <torture_msgs/msg/UInt8.hpp>
#include <torture_msgs/msg/Windows.hpp>
#include <torture_msgs/msg/Words.hpp>

#include "sft/type_support.h"
#include "tests/support/encoded.h"

namespace sft {
namespace {

using namespace detail;

namespace torture = ::torture_msgs::msg;
using test::Encoded;
using torture::Literals;

template <class T>
const Member& member(std::string_view name) {
  static const Member none{};
  for (const Member& m : TypeTable<T>::members) {
    if (m.name == name) return m;
  }
  ADD_FAILURE() << "no member " << name;
  return none;
}

TEST(Literals, OfNumbersAreReadInAllForms) {
  static_assert(Literals::TRUTH && !Literals::LIE);
  static_assert(Literals::MOST_BYTE == 255 && Literals::LETTER == 65 && Literals::LEAST_INT8 == -128);
  static_assert(Literals::BINARY == 0xA5 && Literals::HEXADECIMAL == -127 && Literals::OCTAL == 511);
  static_assert(Literals::DECIMAL == 1'000'000 && Literals::ZEROS == 7);
  static_assert(Literals::LEAST_INT64 == std::numeric_limits<std::int64_t>::min());
  static_assert(Literals::MOST_UINT64 == std::numeric_limits<std::uint64_t>::max());
  static_assert(Literals::TENTH == 0.1F && Literals::MOST_FLOAT32 == std::numeric_limits<float>::max());
  static_assert(Literals::WHOLE == 3.0 && Literals::SMALL == -0.0025 && Literals::POINT == 0.5);
  static_assert(Literals::GREAT == 1e300);
}

TEST(Literals, OfStringsAreReadInAllForms) {
  EXPECT_EQ(Literals::PLAIN, "without quotes");
  EXPECT_EQ(Literals::EMPTY, "");
  EXPECT_EQ(Literals::QUOTED, "with spaces  ");
  EXPECT_EQ(Literals::SINGLE, "say \"hi\"");
  EXPECT_EQ(Literals::ESCAPED, "say \"hi\"\n\ttab \\ AA\xC2\xB5\xF0\x9F\x98\x80");
  EXPECT_EQ(Literals::APOSTROPHE, "it's");
  EXPECT_EQ(Literals::PATH, "C:\\dir");
  EXPECT_EQ(Literals::UTF8,
            "gr\xC3\xBC\xC3\x9F"
            "e, \xE4\xB8\x96\xE7\x95\x8C");
  EXPECT_EQ(Literals::HASH, "a # b");
  EXPECT_EQ(Literals::EQUALS, "a=b");
}

TEST(Literals, AreDefaults) {
  const Literals l;
  EXPECT_TRUE(l.yes);
  EXPECT_FALSE(l.no);
  EXPECT_EQ(l.most_byte, 255);
  EXPECT_EQ(l.letter, 0x41);
  EXPECT_EQ(l.least, -128);
  EXPECT_EQ(l.tenth, 0.1F);
  EXPECT_EQ(l.whole, 3.0);
  EXPECT_EQ(l.text, "two words");
  EXPECT_EQ(l.exact, "f\xC3\xB6ur");
  EXPECT_EQ(l.equals, "a=b");
}

TEST(Literals, AreDefaultsOfCollections) {
  const Literals l;
  EXPECT_EQ(l.extremes[0], std::numeric_limits<std::int64_t>::min());
  EXPECT_EQ(l.flags, (std::array<std::uint8_t, 3>{1, 0, 1}));
  EXPECT_EQ(l.reals, (std::array{1.F, -0.5F}));
  EXPECT_EQ(l.naturals, (std::vector{std::uint64_t{0}, std::numeric_limits<std::uint64_t>::max()}));
  EXPECT_EQ(l.names, (std::vector<std::string>{"a, b", "c\"d", "plain", "\"", ""}));
  EXPECT_EQ(l.short_names, (std::vector<std::string>{"ab", "c"}));
  EXPECT_TRUE(l.none.empty());
}

TEST(Names, ThatAreWordsOfCppHaveAnUnderscoreThere) {
  using torture::Words;
  Words words;
  words.class_ = 1;
  words.default_ = 2;
  words.linux_ = 3;
  words.string = "not one";
  const Encoded encoded(words);
  const auto view = view_of<Words, all<Words>>(encoded.state());
  EXPECT_EQ(view.class_(), 1);
  EXPECT_EQ(view.default_(), 2);
  EXPECT_EQ(view.linux_(), 3);
  EXPECT_EQ(view.string(), "not one");
  EXPECT_EQ(member<Words>("class").offset, offsetof(Words, class_));
}

TEST(Names, ThatAreWordsOfIdlOrOfOursStayAsTheyAre) {
  using torture::Words;
  Words words;
  words.module = 1;
  words.data = {2};
  words.size = {3};
  words.view = 4;
  const Encoded encoded(words);
  const auto view = view_of<Words, all<Words>>(encoded.state());
  EXPECT_EQ(view.module(), 1);
  EXPECT_EQ(view.data()[0], 2);
  EXPECT_EQ(view.size()[0], 3);
  EXPECT_EQ(view.view(), 4);
  EXPECT_EQ(view.reservable().size(), 0U);
}

TEST(Names, OfConstantsThatAreMacrosHaveAnUnderscore) {
  using torture::UInt8;
  static_assert(UInt8::INT8 == 1 && UInt8::UINT8 == 2 && UInt8::STRING == 3 && UInt8::TRUE == 5);
  static_assert(UInt8::EOF_ == -1 && UInt8::NULL_ == 7 && UInt8::EINVAL_ == 22 && UInt8::INT8_MAX_ == 127);
  static_assert(UInt8::BIG_ENDIAN_ == 8 && UInt8::NAN_ == 9.0 && UInt8::M_PI_ == 3.14);
  static_assert(UInt8::T == 10 && UInt8::A == 11);
}

TEST(Names, OfTypesAndPackagesMayBeTakenInCpp) {
  using torture::Deep;
  static_assert(std::is_same_v<decltype(Deep::text), ::std_::msg::String>);
  static_assert(std::is_same_v<decltype(Deep::objects), std::array<::default_::msg::Class, 2>>);
  static_assert(std::is_same_v<decltype(torture::Field_::view), torture::View_>);
  static_assert(torture::View_::VIEW == 1);
  EXPECT_EQ(TypeTable<::default_::msg::Class>::type.name, "default::msg::Class");
  EXPECT_EQ(::std_::msg::String::STD, "std");
  EXPECT_EQ(::default_::msg::Class{}.class_.data, "text");
}

TEST(Names, InPathsAreThoseOfTheMessage) {
  const TypeSupport deep(TypeTable<torture::Deep>::type);
  EXPECT_TRUE(deep.find("header.stamp.sec"));
  EXPECT_TRUE(deep.find("words.class"));
  EXPECT_TRUE(deep.find("objects[].class.data"));
  EXPECT_TRUE(deep.find("middles[].inner[].literals.most_byte"));
  EXPECT_TRUE(deep.find("plan.steps[].length"));
}

TEST(Bounds, AreThoseOfTheMessage) {
  using torture::Collections;
  EXPECT_EQ(member<Collections>("bounded").string_bound, 8U);
  EXPECT_EQ(member<Collections>("few_bounded_strings").string_bound, 8U);
  EXPECT_EQ(member<Collections>("few_bounded_strings").bound, 3U);
  EXPECT_EQ(member<Collections>("two_bounded_strings").count, 2U);
  EXPECT_EQ(member<Collections>("three_flags").kind, Kind::boolean);
  EXPECT_EQ(member<Collections>("few_elements").bound, 3U);
  EXPECT_EQ(member<Collections>("four_nothings").count, 4U);
}

TEST(Files, OfOtherSystemsAreRead) {
  using torture::Windows;
  static_assert(Windows::FIRST == 1);
  EXPECT_EQ(Windows{}.x, 1.5);
  EXPECT_EQ(member<Windows>("x").unit, "m");
  EXPECT_EQ(member<Windows>("views").shape, Shape::sequence);
  EXPECT_EQ(member<Windows>("last").kind, Kind::int32);
}

}  // namespace
}  // namespace sft
