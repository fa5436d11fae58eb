// Layout rules as text: texts that are rules, rules that do not suit their type, and the positions of errors.
#include "layout/rule.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "sft/detail/layout.h"
#include "sft/msg_text.h"

namespace sft {
namespace {

using ::testing::HasSubstr;

/// Returns "" if the text is a rule; otherwise the error's position in bytes, and its message.
std::string fault_of(std::string_view rule) {
  const auto read = layout::read_rule(rule);
  return read ? "" : std::to_string(read.error().at) + ": " + read.error().text;
}

TEST(LayoutRuleTest, HasOneSpellingWhateverTheOrderOfItsRoles) {
  const auto rule = layout::read_rule("  scale=info.size  rows=a columns=b also=x,y ");
  ASSERT_TRUE(rule);
  EXPECT_EQ(rule->text(), "rows=a columns=b scale=info.size also=x,y");
  EXPECT_EQ(layout::read_rule(rule->text())->text(), rule->text());
}

TEST(LayoutRuleTest, HasTheFormThatItsRolesSay) {
  using Form = layout::Form;
  EXPECT_EQ(layout::read_rule("first=a step=b")->form, Form::list);
  EXPECT_EQ(layout::read_rule("also=b")->form, Form::list);
  EXPECT_EQ(layout::read_rule("rows=a columns=b")->form, Form::cells);
  EXPECT_EQ(layout::read_rule("columns=b cell_bytes=c")->form, Form::cells);
  EXPECT_EQ(layout::read_rule("columns=b cell_bytes=c channels=d")->form, Form::points);
}

TEST(LayoutRuleTest, SaysWhichWordIsWrong) {
  EXPECT_EQ(fault_of(""), "0: a layout names roles, as in rows=height columns=width");
  EXPECT_THAT(fault_of("columns=w row=h"), HasSubstr("10: 'row' is no role: expected role=member"));
  EXPECT_THAT(fault_of("rows"), HasSubstr("0: 'rows' is no role: expected role=member"));
  EXPECT_THAT(fault_of("rows = h columns=w"), HasSubstr("0: 'rows' is no role"));
  EXPECT_EQ(fault_of("rows=h columns=w rows=h"), "17: rows is given twice");
  EXPECT_THAT(fault_of("columns=w rows="), HasSubstr("15: this is not the name of a member"));
  for (const char* path : {"1a", "a.", ".a", "a..b", "a[]", "a-b", "a,b", "\xc3\xa4"})
    EXPECT_THAT(fault_of("columns=" + std::string(path)), HasSubstr("8: ")) << path;
  EXPECT_THAT(fault_of("also=a,,b"), HasSubstr("7: this is not the name of a member"));
  EXPECT_EQ(fault_of("also=a also=b"), "7: also is given twice: separate its members by commas");
  EXPECT_EQ(fault_of(std::string(300, ' ')), "0: a layout has at most 255 bytes");
}

TEST(LayoutRuleTest, NamesRolesThatLackAnotherOneOrContradictIt) {
  EXPECT_EQ(fault_of("scale=s rows=h"), "8: rows needs columns beside it");
  EXPECT_EQ(fault_of("columns=w row_bytes=b"), "10: row_bytes needs rows beside it");
  EXPECT_EQ(fault_of("columns=w channels=c"), "10: channels needs cell_bytes beside it");
  EXPECT_EQ(fault_of("cell_bytes=b"), "0: cell_bytes needs columns beside it");
  EXPECT_EQ(fault_of("columns=w scale=s"), "10: scale needs rows beside it");
  EXPECT_EQ(fault_of("rows=h columns=w origin=o"), "17: origin needs scale beside it");
  EXPECT_EQ(fault_of("rows=h columns=w encoding=e"), "17: encoding needs row_bytes beside it");
  EXPECT_EQ(fault_of("rows=h columns=w first=f"), "17: first contradicts columns: leave one of them out");
  EXPECT_EQ(fault_of("rows=h columns=w row_bytes=r cell_bytes=c encoding=e"),
            "42: encoding contradicts cell_bytes: leave one of them out");
  EXPECT_EQ(fault_of("columns=w cell_bytes=c channels=d also=e"),
            "39: also contradicts channels: leave one of them out");
}

TEST(LayoutRuleTest, NamesMembersThatHaveTwoRoles) {
  EXPECT_EQ(fault_of("rows=n columns=n"), "15: 'n' is rows already");
  EXPECT_EQ(fault_of("rows=h columns=w scale=p.x origin=p"), "34: 'p' is scale already");
  EXPECT_EQ(fault_of("first=a also=a"), "13: 'a' is first already");
  EXPECT_EQ(fault_of("rows=ab columns=abc"), "");
}

// ---- rules and their types ----

/// Returns the error for a message with these fields, without the name of the message.
std::string fault_in(std::string_view fields) {
  constexpr std::string_view nested =
      "===\nMSG: geometry_msgs/Pose\ngeometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n"
      "===\nMSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n"
      "===\nMSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"
      "===\nMSG: my_msgs/Info\nuint32 width\nuint32 height\nfloat32 size\n";
  const auto type = from_msg("my_msgs/Example", std::string(fields) + std::string(nested));
  if (type) return "";
  constexpr std::string_view before = "my_msgs/msg/Example:";
  EXPECT_TRUE(type.error().message.starts_with(before)) << type.error().message;
  return type.error().message.substr(before.size());
}

TEST(LayoutRuleOfATypeTest, MayNameMembersOfStructsAndStandInAnyCommentOfItsField) {
  EXPECT_EQ(fault_in("Info info\ngeometry_msgs/Pose pose\n"
                     "# @sft_layout rows=info.height columns=info.width scale=info.size origin=pose\n"
                     "int16[<=100] cells  # [m]\n"),
            "");
  EXPECT_EQ(fault_in("uint32 w\nuint8[] cells # [m] @sft_layout columns=w\n"), "");
  EXPECT_EQ(fault_in("uint32 w\nuint8[] cells\n   # @sft_layout columns=w\n"), "");
}

TEST(LayoutRuleOfATypeTest, NamesNoMemberThatThereIsNot) {
  EXPECT_EQ(fault_in("uint32 w\nuint8[] cells # @sft_layout rows=h columns=w\n"),
            "2:34: cells: there is no member 'h'");
  EXPECT_EQ(fault_in("Info info\nuint8[] cells # @sft_layout columns=info.depth\n"),
            "2:37: cells: there is no member 'info.depth'");
  EXPECT_THAT(fault_in("Info[] info\nuint8[] cells # @sft_layout columns=info.width\n"),
              HasSubstr("2:37: cells: 'info' is not a single struct"));
  EXPECT_THAT(fault_in("uint32 w\nuint8[] cells # @sft_layout columns=w.x\n"),
              HasSubstr("'w' is not a single struct"));
}

TEST(LayoutRuleOfATypeTest, NamesNoMemberOfAnotherKind) {
  const std::string integer = " is not a single uint32, which columns has to be";
  for (const char* type : {"int32", "uint16", "uint64", "float32", "uint32[]", "uint32[2]", "string", "Info"})
    EXPECT_EQ(fault_in(std::string(type) + " w\nuint8[] cells # @sft_layout columns=w\n"),
              "2:37: cells: 'w'" + integer);
  EXPECT_EQ(fault_in("int32 a\nfloat64[] cells # @sft_layout first=a\n"),
            "2:37: cells: 'a' is not a single float32 or float64, which first has to be");
  EXPECT_THAT(fault_in("uint32 w\nuint32 h\nfloat32 s\nInfo o\n"
                       "uint8[] cells # @sft_layout rows=h columns=w scale=s origin=o\n"),
              HasSubstr("'o' is not a single struct like geometry_msgs/Pose"));
  EXPECT_THAT(fault_in("uint32 w\nuint32 b\nInfo[] c\n"
                       "uint8[] cells # @sft_layout columns=w cell_bytes=b channels=c\n"),
              HasSubstr("'c' is not a sequence of structs like sensor_msgs/PointField"));
}

TEST(LayoutRuleOfATypeTest, BelongsToASequenceOfNumbers) {
  const std::string expected =
      "2:29: cells: a layout belongs to a sequence of numbers, outside of all other sequences";
  EXPECT_EQ(fault_in("uint32 w\nfloat32 cells # @sft_layout columns=w\n").substr(5), expected.substr(5));
  EXPECT_THAT(fault_in("uint32 w\nuint8[4] cells # @sft_layout columns=w\n"),
              HasSubstr("belongs to a sequence"));
  EXPECT_THAT(fault_in("uint32 w\nstring[] cells # @sft_layout columns=w\n"),
              HasSubstr("belongs to a sequence"));
  EXPECT_THAT(fault_in("uint32 w\nInfo[] cells # @sft_layout columns=w\n"),
              HasSubstr("belongs to a sequence"));
  EXPECT_THAT(fault_in("uint32 w\nuint32 b\nfloat32[] cells # @sft_layout columns=w cell_bytes=b\n"),
              HasSubstr("cell_bytes counts bytes, so the field has to be a sequence of uint8 or octet"));
  EXPECT_THAT(fault_in("uint8[] cells # @sft_layout also=other\nstring[] other\n"),
              HasSubstr("'other' is not a sequence of numbers"));
  EXPECT_THAT(fault_in("uint8[] cells # @sft_layout also=cells\n"),
              HasSubstr("also names other fields than the annotated one"));
}

TEST(LayoutRuleOfATypeTest, SharesNoMemberWithAnotherRule) {
  EXPECT_EQ(fault_in("uint32 w\nuint8[] a # @sft_layout columns=w\nuint8[] b # @sft_layout columns=w\n"),
            "3:33: b: 'w' belongs to another layout already: name all fields that share it in one, by also=");
  EXPECT_THAT(fault_in("uint32 w\nuint8[] a # @sft_layout columns=w also=b\n"
                       "float32 f\nuint8[] b # @sft_layout first=f\n"),
              HasSubstr("2:40: a: 'b' belongs to another layout already"));
}

TEST(LayoutRuleOfATypeTest, StandsWhereAFieldIsMeant) {
  EXPECT_THAT(fault_in("# @sft_layout columns=w\nuint8[] cells\nuint32 w\n"),
              HasSubstr("1:15: the comment at the top belongs to the message"));
  EXPECT_THAT(fault_in("uint32 w\n# @sft_layout columns=w\nuint32 N=5\nuint8[] cells\n"),
              HasSubstr("2:15: N: a layout belongs to a field, not to a constant"));
  EXPECT_THAT(fault_in("uint32 w\nuint8[] cells\n# @sft_layout columns=w\n"),
              HasSubstr("3:15: no field follows that the layout could belong to"));
  EXPECT_THAT(fault_in("uint32 w\n# @sft_layout columns=w\nuint8[] cells # @sft_layout columns=w\n"),
              HasSubstr("3:29: a field has one layout"));
  EXPECT_THAT(fault_in("uint32 w\nuint8[] cells # @sft_layout(columns=w)\n"),
              HasSubstr("2:28: cells: '(columns' is no role"));
}

TEST(LayoutRuleOfATypeTest, OfAnotherMessageIsReportedThere) {
  const auto type = from_msg("my_msgs/Outer",
                             "Inner inner\n===\nMSG: my_msgs/Inner\nuint32 w\n\n"
                             "uint8[] cells # @sft_layout columns=v\n");
  ASSERT_FALSE(type);
  EXPECT_EQ(type.error().message, "my_msgs/msg/Inner:3:37: cells: there is no member 'v'");
}

}  // namespace
}  // namespace sft
