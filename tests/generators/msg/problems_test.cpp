// Wrong texts are refused. The tests check the line and the message of each problem.
#include <gtest/gtest.h>

#include "tests/generators/msg/parsed.h"

namespace sft::msg {
namespace {

using test::problems;

TEST(WrongTypes, AreRefused) {
  EXPECT_EQ(
      problems("double x"),
      "1 x: 'double' is not a type: expected bool, byte, char, int8 to int64, uint8 to uint64, float32, "
      "float64, string, or a message as Name or package/Name");
  for (const char* type :
       {"int", "int128", "pkg/", "/Point", "pkg/point", "Pkg/Point", "p__q/Point", "p_/Point",
        "pkg/srv/Point", "a/b/c/Point", "pkg//Point", "point", "Po_int", "_Point", "int32*"}) {
    EXPECT_NE(problems(std::string(type) + " x").find("1 x: '" + std::string(type) + "' is not a type"),
              std::string::npos)
        << type;
  }
}

TEST(WrongTypes, OfRos1AreToldWhatToUse) {
  EXPECT_EQ(problems("time x"), "1 x: 'time' is a type of ROS 1: use builtin_interfaces/Time");
  EXPECT_EQ(problems("duration[] x"), "1 x: 'duration' is a type of ROS 1: use builtin_interfaces/Duration");
}

TEST(WideStrings, AreRefused) {
  const std::string expected = "1 x: wide characters are not supported: use string, which holds UTF-8";
  EXPECT_EQ(problems("wstring x"), expected);
  EXPECT_EQ(problems("wstring<=5[3] x"), expected);
  EXPECT_EQ(problems("wstring x \"a\""), expected);
}

TEST(Sizes, AreWholeNumbersAboveZero) {
  EXPECT_EQ(problems("int32[0] x"), "1 x: '0' is not a size: expected a whole number from 1 to 2147483647");
  EXPECT_EQ(problems("string<=0 x"), "1 x: '0' is not a size: expected a whole number from 1 to 4294967295");
  for (const char* type :
       {"int32[-1]", "int32[1.5]", "int32[a]", "int32[2147483648]", "int32[<=4294967296]",
        "int32[99999999999999999999]", "int32[ ]", "string<=", "string<=a", "string<=5]"}) {
    EXPECT_NE(problems(std::string(type) + " x"), "") << type;
  }
}

TEST(Brackets, ComeInOnePairAtTheEnd) {
  EXPECT_EQ(problems("int32[2][3] x"),
            "1 x: arrays have one dimension: put the inner one into a message of its own");
  EXPECT_EQ(problems("int32] x"), "1 x: ']' without a '[': expected T[N], T[] or T[<=N]");
  EXPECT_NE(problems("int32[3 x"), "");
  EXPECT_EQ(problems("int32<=5 x"),
            "1 x: 'int32<=5' is not a type: a bound is written string<=N, or T[<=N], without spaces");
}

TEST(Names, OfFieldsAreLowerCase) {
  EXPECT_EQ(problems("int32 Speed"),
            "1 : 'Speed' is not the name of a field: expected a lower-case letter, then lower-case letters, "
            "digits and single underscores, as in max_speed; a constant is written NAME=value");
  for (const char* name :
       {"sPeed", "_speed", "speed_", "spe__ed", "1speed", "spe-ed", "[3]", "gr\xC3\xB6sse"}) {
    EXPECT_NE(problems("int32 " + std::string(name)).find("is not the name of a field"), std::string::npos)
        << name;
  }
}

TEST(Names, OfConstantsAreUpperCase) {
  EXPECT_EQ(
      problems("int32 speed=5"),
      "1 : 'speed' is not the name of a constant: expected a capital letter, then capital letters, digits "
      "and single underscores, as in MAX_SPEED; a default is written without '='");
  for (const char* name : {"Speed", "_SPEED", "SPEED_", "SPE__ED", "1SPEED", "SPE-ED"}) {
    EXPECT_NE(problems("int32 " + std::string(name) + "=5").find("is not the name of a constant"),
              std::string::npos)
        << name;
  }
}

TEST(Names, OfPackagesAndMessagesAreThoseOfRos) {
  EXPECT_NE(problems("", {"my-msgs", "A"}).find("1 : 'my-msgs' is not a package name"), std::string::npos);
  EXPECT_NE(problems("", {"my_msgs", "a_b"}).find("1 : 'a_b' is not a message name"), std::string::npos);
  for (const char* package : {"", "My", "1msgs", "my__msgs", "msgs_"})
    EXPECT_NE(problems("", {package, "A"}), "") << package;
  for (const char* name : {"", "point", "Po_int", "1Point", "Point-2"})
    EXPECT_NE(problems("", {"my_msgs", name}), "") << name;
}

TEST(Names, HaveAtMost255Bytes) {
  const std::string longest(255, 'a');
  EXPECT_EQ(problems("int8 " + longest), "");
  EXPECT_NE(problems("int8 " + longest + "a"), "");
  EXPECT_NE(problems("", {longest + "a", "A"}), "");
}

TEST(Names, AreGivenOnce) {
  EXPECT_EQ(problems("int32 x\nint8 y\nint8 x"), "3 x: there is one already, in line 1: rename one of them");
  EXPECT_EQ(problems("int32 X=1\n\nint8 X=2"), "3 X: there is one already, in line 1: rename one of them");
}

TEST(Layouts, ThatAreNoRulesAreRefusedWithTheirColumn) {
  EXPECT_EQ(problems("uint32 w\nuint8[] x  # [m] @sft_layout rows=w\n"),
            "2 x: rows needs columns beside it (column 30)");
  EXPECT_NE(problems("uint8[] x\n\t# @sft_layout line=w").find("2 x: 'line' is no role"), std::string::npos);
  EXPECT_EQ(problems("uint8[] x  # @sft_layout"),
            "1 x: a layout names roles, as in rows=height columns=width (column 25)");
  EXPECT_EQ(problems("uint8[] x  # @sft_layout columns=w columns=h"),
            "1 x: columns is given twice (column 36)");
}

TEST(Layouts, BelongToOneFieldEach) {
  EXPECT_EQ(problems("\n# @sft_layout columns=w\n# @sft_layout columns=h\nuint8[] x"),
            "3 : a field has one layout (column 15)");
  EXPECT_EQ(problems("\n# @sft_layout columns=w\nuint8[] x\n # @sft_layout columns=w"),
            "4 x: a field has one layout (column 16)");
  EXPECT_EQ(problems("\n# @sft_layout columns=w\nuint8 X=1"),
            "2 X: a layout belongs to a field, not to a constant (column 15)");
  EXPECT_EQ(problems("uint8 y\n# @sft_layout columns=w\n"),
            "2 : no field follows that the layout could belong to (column 15)");
  EXPECT_EQ(problems("uint8 X=1\n  # @sft_layout columns=w\n"),
            "2 : no field stands before this layout (column 17)");
  EXPECT_NE(problems("# @sft_layout columns=w\nuint8[] x").find("1 : the comment at the top belongs to the"),
            std::string::npos);
}

TEST(Constants, AreOfPrimitiveTypes) {
  const std::string expected = " cannot be the type of a constant: use a primitive type or string";
  EXPECT_EQ(problems("int32[] X=[1]"), "1 X: 'int32[]'" + expected);
  EXPECT_EQ(problems("string<=5 X=a"), "1 X: 'string<=5'" + expected);
  EXPECT_EQ(problems("Point X=1"), "1 X: 'Point'" + expected);
}

TEST(Constants, HaveAValue) {
  EXPECT_EQ(problems("int32 X="), "1 X: '' is not an integer: expected one such as -42, 0xFF, 0o17 or 0b101");
}

TEST(Values, AreOfTheFieldsType) {
  EXPECT_EQ(problems("bool x yes"), "1 x: 'yes' is not a bool: expected true or false");
  EXPECT_EQ(problems("int32 x 1.5"),
            "1 x: '1.5' is not an integer: expected one such as -42, 0xFF, 0o17 or 0b101");
  EXPECT_EQ(
      problems("float32 x inf"),
      "1 x: 'inf' is not a number: expected one such as -1.5 or 2e-3; infinity and NaN cannot be written");
  for (const char* text :
       {"a", "0x", "0xG", "0b2", "0o8", "1__0", "_1", "1_", "--1", "+-1", "1 2", "'1'", "[1]"})
    EXPECT_NE(problems("int32 x " + std::string(text)), "") << text;
  for (const char* text : {"a", "nan", "-inf", "infinity", "0x1p3", "1e", "1,5", "--1", "1.5.2", ".", "1 2"})
    EXPECT_NE(problems("float64 x " + std::string(text)), "") << text;
}

TEST(Values, AreInTheRangeOfTheirType) {
  EXPECT_EQ(problems("uint8 x 256"), "1 x: '256' is out of range: expected 0 to 255");
  EXPECT_EQ(problems("uint8 X=-1"), "1 X: '-1' is out of range: expected 0 to 255");
  EXPECT_EQ(problems("int8 x -129"), "1 x: '-129' is out of range: expected -128 to 127");
  EXPECT_EQ(problems("char x 0x100"), "1 x: '0x100' is out of range: expected 0 to 255");
  EXPECT_EQ(
      problems("int64 x -9223372036854775809"),
      "1 x: '-9223372036854775809' is out of range: expected -9223372036854775808 to 9223372036854775807");
  EXPECT_EQ(problems("uint64 x 18446744073709551616"),
            "1 x: '18446744073709551616' is out of range: expected 0 to 18446744073709551615");
  EXPECT_EQ(problems("float32 x 3.5e38"),
            "1 x: '3.5e38' is out of range: expected a float32 of at most 3.40282e+38");
  EXPECT_NE(problems("float64 x -1e400"), "");
}

TEST(Lists, AreInBrackets) {
  EXPECT_EQ(problems("int32[] x 1, 2"), "1 x: '1, 2' is not a list: expected one such as [1, 2, 3]");
  EXPECT_NE(problems("int32[] x ["), "");
  EXPECT_NE(problems("int32[] x [1"), "");
}

TEST(Lists, HaveNoMissingElements) {
  EXPECT_EQ(problems("int32[] x [1, , 2]"), "1 x: element 1 is missing");
  EXPECT_EQ(problems("int32[] x [1, 2,]"), "1 x: element 2 is missing");
  EXPECT_EQ(problems("string[] x [, \"a\"]"), "1 x: element 0 is missing");
}

TEST(Lists, HaveAsManyElementsAsTheArrayOrTheBoundAllows) {
  EXPECT_EQ(problems("int32[3] x [1, 2]"), "1 x: 2 elements: expected 3, the size of the array");
  EXPECT_EQ(problems("int32[3] x []"), "1 x: 0 elements: expected 3, the size of the array");
  EXPECT_EQ(problems("int32[<=1] x [1, 2]"), "1 x: 2 elements: expected at most 1, the bound");
}

TEST(Lists, NameTheElementThatIsWrong) {
  EXPECT_EQ(problems("uint8[] x [1, 300]"), "1 x: element 1: '300' is out of range: expected 0 to 255");
}

TEST(Strings, AreNotLongerThanTheirBound) {
  EXPECT_EQ(problems("string<=3 x four"),
            "1 x: 'four' takes 4 bytes: expected at most 3, the string's bound");
  EXPECT_EQ(problems("string<=2[] x [\"ab\", \"\xC3\xB6z\"]"),
            "1 x: element 1: '\"\xC3\xB6z\"' takes 3 bytes: expected at most 2, the string's bound");
}

TEST(Strings, EndWithTheQuoteThatTheyBeginWith) {
  EXPECT_EQ(
      problems("string x \"a # b\""),
      "1 x: the quote that ends '\"a' is missing: '#' begins a comment even in quotes, where \\x23 means "
      "it");
  EXPECT_EQ(problems("string x \"a\" and \"b\""),
            "1 x: '\"a\" and \"b\"' goes on behind the quote that ends it: write \\\" for a quote inside");
  for (const char* text : {"\"", "'", "'a\"", "\"a\\\""})
    EXPECT_NE(problems("string x " + std::string(text)), "");
  EXPECT_NE(problems("string[] x [\"a]"), "");
  EXPECT_NE(problems("string[] x [\"a\" \"b\"]"), "");
}

TEST(Strings, AreUtf8WithoutNul) {
  EXPECT_EQ(problems(R"(string x "a\0b")"), "1 x: a string cannot hold a NUL: leave it out");
  EXPECT_NE(problems(R"(string x "\xff")").find("is not UTF-8"), std::string::npos);
  EXPECT_NE(problems(R"(string x "\u12")").find("bad escape at '\\u12'"), std::string::npos);
  for (const char* text : {R"("\x4")", R"("\400")", R"("\ud800")", R"("\U00110000")", R"(a\)"})
    EXPECT_NE(problems("string x " + std::string(text)), "") << text;
}

TEST(Messages, HaveNoDefaults) {
  const std::string expected =
      "1 x: fields of a message type have no defaults of their own: give them in that message";
  EXPECT_EQ(problems("Point x 1"), expected);
  EXPECT_EQ(problems("Point[] x [1]"), expected);
}

TEST(Lines, AreDefinitions) {
  const std::string expected =
      " is not a definition: expected 'type name', 'type name default' or 'type NAME=value'";
  EXPECT_EQ(problems("int32"), "1 : 'int32'" + expected);
  EXPECT_EQ(problems("int32 =5"), "1 : 'int32 =5'" + expected);
  EXPECT_EQ(problems("int32 # x"), "1 : 'int32'" + expected);
}

TEST(Services, AreNoMessages) {
  EXPECT_EQ(problems("int32 x\n---\nint32 y"),
            "2 : '---' separates the two parts of a service: it stands once in a .srv file, in a line with "
            "nothing else");
}

TEST(Texts, AreUtf8) {
  EXPECT_EQ(problems("int32 x\r\n# gr\xFC\xDF"
                     "e\n"),
            "2 : this is not UTF-8: convert the file");
}

TEST(Texts, HaveNoControlCharacters) {
  EXPECT_EQ(problems(std::string_view("string x a\0b", 12)),
            "1 : control characters are not supported here: write them as escapes in strings");
  EXPECT_NE(problems("string x \"a\x1b\""), "");
}

TEST(Texts, AreOfLimitedSize) {
  EXPECT_EQ(problems(std::string(Limits::bytes, '\n')), "");
  EXPECT_EQ(problems(std::string(Limits::bytes + 1, '\n')),
            "1 : 1048577 bytes: expected at most 1048576: put parts into messages of their own");
}

TEST(Texts, HaveALimitedNumberOfFields) {
  std::string text;
  for (std::size_t i = 0; i < Limits::members; ++i) text += "int8 x" + std::to_string(i) + "\n";
  EXPECT_EQ(problems(text), "");
  EXPECT_EQ(problems(text + "int8 A=1"), "4097 : too many fields and constants: expected at most 4096");
}

TEST(Problems, AreAllReported) {
  EXPECT_EQ(problems("int33 x\nint32 y\nuint8 z 300\n\nint32 y"),
            "1 x: 'int33' is not a type: expected bool, byte, char, int8 to int64, uint8 to uint64, float32, "
            "float64, string, or a message as Name or package/Name\n"
            "3 z: '300' is out of range: expected 0 to 255\n"
            "5 y: there is one already, in line 2: rename one of them");
}

TEST(Problems, OfATextFullOfThemAreNotAllReported) {
  std::string text;
  for (int i = 0; i < 1000; ++i) text += "?\n";
  EXPECT_EQ(parse(text, test::example).error().size(), Limits::problems);
}

TEST(Problems, NameTheMemberIfItHasAName) {
  EXPECT_EQ(problems("int33 x").substr(0, 4), "1 x:");
  EXPECT_EQ(problems("int33 X=1").substr(0, 4), "1 X:");
  EXPECT_EQ(problems("int33 [m]").substr(0, 3), "1 :");
}

TEST(Problems, QuoteLongTextsInPart) {
  const std::string line = problems("int8 x " + std::string(1000, '9'));
  EXPECT_NE(line.find("999...' is out of range"), std::string::npos);
  EXPECT_LT(line.size(), 200U);
}

}  // namespace
}  // namespace sft::msg
