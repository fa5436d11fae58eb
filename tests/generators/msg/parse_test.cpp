// These tests check the definitions that the parser makes of .msg files.
#include <gtest/gtest.h>

#include <limits>

#include "tests/generators/msg/parsed.h"

namespace sft::msg {
namespace {

using test::parsed;

Field field(std::string_view text) {
  const Definition definition = parsed(text);
  return definition.fields.empty() ? Field{} : definition.fields.front();
}

Type type(std::string_view text) { return field(std::string(text) + " x").type; }

/// Returns the unit of the only field in these lines.
std::string unit(std::string_view lines) { return field(lines).unit; }

template <class T>
T value(std::string_view type, std::string_view text) {
  const Field f = field(std::string(type) + " x " + std::string(text));
  EXPECT_EQ(f.initial.size(), 1U) << text;
  return f.initial.empty() ? T{} : std::get<T>(f.initial.front());
}

std::string string(std::string_view text) { return value<std::string>("string", text); }

std::vector<Value> values(std::string_view type, std::string_view text) {
  return field(std::string(type) + " x " + std::string(text)).initial;
}

TEST(Types, OfAllPrimitivesHaveTheKindThatRosGivesThem) {
  EXPECT_EQ(type("bool").kind, SFT_BOOLEAN);
  EXPECT_EQ(type("byte").kind, SFT_OCTET);
  EXPECT_EQ(type("char").kind, SFT_UINT8);
  EXPECT_EQ(type("float32").kind, SFT_FLOAT32);
  EXPECT_EQ(type("float64").kind, SFT_FLOAT64);
  EXPECT_EQ(type("int8").kind, SFT_INT8);
  EXPECT_EQ(type("uint8").kind, SFT_UINT8);
  EXPECT_EQ(type("int16").kind, SFT_INT16);
  EXPECT_EQ(type("uint16").kind, SFT_UINT16);
  EXPECT_EQ(type("int32").kind, SFT_INT32);
  EXPECT_EQ(type("uint32").kind, SFT_UINT32);
  EXPECT_EQ(type("int64").kind, SFT_INT64);
  EXPECT_EQ(type("uint64").kind, SFT_UINT64);
  EXPECT_EQ(type("string").kind, SFT_STRING);
}

TEST(Types, AreSingleArraysOrSequences) {
  EXPECT_TRUE(type("int32").is_single());
  EXPECT_EQ(type("int32[3]").array_size, 3U);
  EXPECT_TRUE(type("int32[]").is_sequence);
  EXPECT_EQ(type("int32[]").bound, 0U);
  EXPECT_TRUE(type("int32[<=3]").is_sequence);
  EXPECT_EQ(type("int32[<=3]").bound, 3U);
}

TEST(Types, OfStringsHaveABoundOfTheirOwn) {
  EXPECT_EQ(type("string").string_bound, 0U);
  EXPECT_EQ(type("string<=8").string_bound, 8U);
  EXPECT_EQ(type("string<=8[<=3]").string_bound, 8U);
  EXPECT_EQ(type("string<=8[<=3]").bound, 3U);
  EXPECT_EQ(type("string<=8[2]").array_size, 2U);
}

TEST(Types, NameMessagesWithOrWithoutTheirPackage) {
  EXPECT_EQ(type("Point").nested, (TypeName{"my_msgs", "Point"}));
  EXPECT_EQ(type("geometry_msgs/Point").nested, (TypeName{"geometry_msgs", "Point"}));
  EXPECT_EQ(type("geometry_msgs/msg/Point[]").nested, (TypeName{"geometry_msgs", "Point"}));
  EXPECT_EQ(type("Sample_Plan_Feedback").nested.name, "Sample_Plan_Feedback");
}

TEST(Types, CalledHeaderAreOfTheOwnPackageAsInRos2) {
  EXPECT_EQ(type("Header").nested, (TypeName{"my_msgs", "Header"}));
}

TEST(Definitions, KeepTheOrderOfFieldsAndOfConstants) {
  const Definition d = parsed("int8 b\nint8 B=1\nint8 a\nint8 A=2\n");
  ASSERT_EQ(d.fields.size(), 2U);
  ASSERT_EQ(d.constants.size(), 2U);
  EXPECT_EQ(d.fields[0].name + d.fields[1].name, "ba");
  EXPECT_EQ(d.constants[0].name + d.constants[1].name, "BA");
  EXPECT_EQ(d.constants[1].line, 4U);
}

TEST(Definitions, WithoutFieldsHaveTheOneThatRosPutsThere) {
  for (const char* text : {"", "\n", "# nothing", "int8 A=1"}) {
    EXPECT_EQ(field(text).name, "structure_needs_at_least_one_member");
    EXPECT_EQ(field(text).type.kind, SFT_UINT8);
  }
}

TEST(Definitions, MayHaveAnySpacesAndLineEnds) {
  const Definition expected = parsed("int8 A=1\nint8 x 2\nstring s a b\n");
  EXPECT_EQ(parsed("int8 A=1\r\nint8 x 2\r\nstring s a b\r\n"), expected);
  EXPECT_EQ(parsed("int8 A=1\rint8 x 2\rstring s a b"), expected);
  EXPECT_EQ(parsed("\xEF\xBB\xBFint8 A=1\nint8 x 2\nstring s a b"), expected);
  EXPECT_EQ(parsed("\tint8\t  A  =\t1 \n int8\tx\t2  \n  string s a\tb \f\n"), expected);
}

TEST(Definitions, MayHaveCommentsAnywhere) {
  EXPECT_EQ(parsed("# a\n#\n##b\nint8 x#c\n  # d\nint8 y 2#e\nint8 A=1 # = 2\n").fields.size(), 2U);
  EXPECT_EQ(std::get<std::string>(field("string x a # b").initial[0]), "a");
}

TEST(Booleans, AreWordsOrDigits) {
  for (const char* text : {"true", "True", "TRUE", "1"}) EXPECT_TRUE(value<bool>("bool", text));
  for (const char* text : {"false", "False", "fAlSe", "0"}) EXPECT_FALSE(value<bool>("bool", text));
}

TEST(Integers, AreDecimalHexadecimalOctalOrBinary) {
  EXPECT_EQ(value<std::int64_t>("int32", "-42"), -42);
  EXPECT_EQ(value<std::int64_t>("int32", "+42"), 42);
  EXPECT_EQ(value<std::int64_t>("int32", "0xfF"), 255);
  EXPECT_EQ(value<std::int64_t>("int32", "-0X10"), -16);
  EXPECT_EQ(value<std::int64_t>("int32", "0o17"), 15);
  EXPECT_EQ(value<std::int64_t>("int32", "0b101"), 5);
}

TEST(Integers, MayHaveLeadingZerosAndSingleUnderscores) {
  EXPECT_EQ(value<std::int64_t>("int32", "017"), 17);
  EXPECT_EQ(value<std::int64_t>("int32", "1_000_000"), 1'000'000);
  EXPECT_EQ(value<std::int64_t>("int32", "0x_ff_ff"), 0xFFFF);
}

TEST(Integers, ReachTheLimitsOfTheirTypes) {
  EXPECT_EQ(value<std::int64_t>("int8", "-128"), -128);
  EXPECT_EQ(value<std::uint64_t>("byte", "255"), 255U);
  EXPECT_EQ(value<std::uint64_t>("char", "255"), 255U);
  EXPECT_EQ(value<std::uint64_t>("uint8", "-0"), 0U);
  EXPECT_EQ(value<std::int64_t>("int64", "-9223372036854775808"), std::numeric_limits<std::int64_t>::min());
  EXPECT_EQ(value<std::int64_t>("int64", "9223372036854775807"), std::numeric_limits<std::int64_t>::max());
  EXPECT_EQ(value<std::uint64_t>("uint64", "0xFFFFFFFFFFFFFFFF"), std::numeric_limits<std::uint64_t>::max());
}

TEST(Reals, AreDecimal) {
  EXPECT_EQ(value<double>("float64", "-1.5"), -1.5);
  EXPECT_EQ(value<double>("float64", "+2"), 2.0);
  EXPECT_EQ(value<double>("float64", ".5"), 0.5);
  EXPECT_EQ(value<double>("float64", "5."), 5.0);
  EXPECT_EQ(value<double>("float64", "1_0.5e-3"), 10.5e-3);
  EXPECT_EQ(value<double>("float64", "1E+3"), 1000.0);
}

TEST(Reals, ReachTheLimitsOfTheirTypes) {
  EXPECT_EQ(value<double>("float32", "3.4028235e38"), 3.4028235e38);
  EXPECT_EQ(value<double>("float64", "1.7976931348623157e308"), std::numeric_limits<double>::max());
  EXPECT_EQ(value<double>("float64", "1e-400"), 0.0);
}

TEST(Strings, MayHaveQuotesOfBothKindsOrNone) {
  EXPECT_EQ(string("\"a b\""), "a b");
  EXPECT_EQ(string("'a b'"), "a b");
  EXPECT_EQ(string("a b"), "a b");
  EXPECT_EQ(string("\"\""), "");
  EXPECT_EQ(string("\" a \""), " a ");
}

TEST(Strings, MayHoldQuotes) {
  EXPECT_EQ(string("\"it's\""), "it's");
  EXPECT_EQ(string("'say \"hi\"'"), "say \"hi\"");
  EXPECT_EQ(string("\"say \\\"hi\\\"\""), "say \"hi\"");
  EXPECT_EQ(string("it's"), "it's");
}

TEST(Strings, MayHaveEscapes) {
  EXPECT_EQ(string(R"("\a\b\f\n\r\t\v\\\'\"")"), "\a\b\f\n\r\t\v\\'\"");
  EXPECT_EQ(string(R"("\x41\101\7")"), "AA\a");
  EXPECT_EQ(string(R"("\xC3\xB6\u00f6\U0001F600")"), "\xC3\xB6\xC3\xB6\xF0\x9F\x98\x80");
  EXPECT_EQ(string(R"("a\x23b")"), "a#b");
}

TEST(Strings, KeepABackslashThatEscapesNothing) { EXPECT_EQ(string(R"("C:\dir\.")"), R"(C:\dir\.)"); }

TEST(Strings, MayHoldAnEqualsSign) {
  EXPECT_EQ(string("\"a=b\""), "a=b");
  EXPECT_EQ(std::get<std::string>(parsed("string X=a=b").constants[0].value), "a=b");
}

TEST(Strings, OfConstantsMayBeEmpty) {
  EXPECT_EQ(std::get<std::string>(parsed("string X=").constants[0].value), "");
}

TEST(Lists, GiveEachElementOfArraysAndSequences) {
  const std::vector<Value> expected{std::int64_t{1}, std::int64_t{-2}, std::int64_t{3}};
  EXPECT_EQ(values("int32[3]", "[1, -2, 3]"), expected);
  EXPECT_EQ(values("int32[]", "[1,-2 , 0x3]"), expected);
  EXPECT_EQ(values("int32[<=3]", "[ 1, -2, 3 ]"), expected);
  EXPECT_TRUE(values("int32[]", "[]").empty());
  EXPECT_TRUE(values("int32[]", "[ ]").empty());
}

TEST(Lists, OfStringsMayHaveCommasInQuotes) {
  const std::vector<Value> expected{"a, b", "c\"d", "e f", ""};
  EXPECT_EQ(values("string[]", R"(["a, b", 'c"d', e f, ""])"), expected);
  EXPECT_EQ(values("string[]", R"(["a, b",'c"d',e f,"",])"), expected);
}

TEST(Units, AreWhatStandsInBracketsInTheCommentOfAField) {
  EXPECT_EQ(unit("float64 x  # how fast [m/s]"), "m/s");
  EXPECT_EQ(unit("\n# how fast [m/s]\nfloat64 x"), "m/s");
  EXPECT_EQ(unit("float64 x\n  # how fast\n  # [m/s]"), "m/s");
  EXPECT_EQ(unit("float64 x"), "");
}

TEST(Units, AreNotRangesNorAlternatives) {
  EXPECT_EQ(unit("float64 x  # [0, 1]"), "");
  EXPECT_EQ(unit("float64 x  # [0, 1] [m]"), "m");
  EXPECT_EQ(unit("float64 x  # [m] or [cm]"), "");
  EXPECT_EQ(unit("float64 x  # []"), "");
  EXPECT_EQ(unit("float64 x  # [m"), "");
}

TEST(Units, OfTheMessageOrOfAConstantAreNoFieldsUnits) {
  EXPECT_EQ(unit("# [m]\nfloat64 x"), "");
  EXPECT_EQ(unit("\nint8 A=1 # [m]\n  # [m]\nfloat64 x"), "");
}

TEST(Layouts, StandBesideAboveOrIndentedBelowTheirField) {
  const auto layout = [](std::string_view text) { return parsed(text).fields.at(0).layout; };
  const Layout beside = layout("uint8[] x  ## [m] @sft_layout  columns=w  rows=h \nuint32 w");
  EXPECT_EQ(beside.text, "columns=w  rows=h");
  EXPECT_EQ(beside.line, 1U);
  EXPECT_EQ(beside.column, 32U);
  EXPECT_EQ(parsed("uint8[] x  # [m] @sft_layout columns=w").fields.at(0).unit, "m");
  EXPECT_EQ(layout("\n# @sft_layout columns=w\n\n# more\nuint8[] x").line, 2U);
  EXPECT_EQ(layout("uint8[] x\n  # @sft_layout columns=w").line, 2U);
  EXPECT_EQ(layout("uint8[] x\n# @sft_layout columns=w\nuint8[] y").text, "");
  EXPECT_EQ(layout("uint8[] x  # sft_layout columns=w").text, "") << "only a comment";
}

}  // namespace
}  // namespace sft::msg
