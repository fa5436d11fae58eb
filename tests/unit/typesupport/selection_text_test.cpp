// Selections as text: the texts that are accepted, the printed form, and the errors for mistakes.
#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

#include <sensor_msgs/msg/BatteryState.hpp>
#include <sensor_msgs/msg/Image.hpp>
#include <sensor_msgs/msg/Imu.hpp>
#include <sensor_msgs/msg/LaserScan.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include "sft/detail/type_table.h"
#include "sft/type_support.h"

namespace sft {
namespace {

using sensor_msgs::msg::BatteryState;
using sensor_msgs::msg::Image;
using sensor_msgs::msg::Imu;
using sensor_msgs::msg::LaserScan;
using sensor_msgs::msg::PointCloud2;

/// Returns the canonical form of the text, or the error. Expects the canonical form to have the same meaning.
std::string read(const TypeSupport& type, std::string_view text) {
  const Result<Selection> selection = type.parse_selection(text);
  if (!selection) return selection.error().message;
  const std::string printed = type.format_selection(*selection);
  const Result<Selection> again = type.parse_selection(printed);
  EXPECT_TRUE(again && *again == *selection) << printed;
  const Result<Selection> from_bytes = Selection::from_bytes(selection->to_bytes(), type.leaves());
  EXPECT_TRUE(from_bytes && *from_bytes == *selection) << printed;
  return printed;
}

template <class T>
std::string read(std::string_view text) {
  return read(type_support<T>(), text);
}

template <class T>
void expect_same(std::string_view text) {
  EXPECT_EQ(read<T>(text), text);
}

TEST(SelectionText, OfWholeFieldsIsThatOfAMask) {
  for (const char* text : {"", "*", "header.stamp, data", "fields[].name", "fields.size"})
    expect_same<PointCloud2>(text);
  EXPECT_EQ(read<PointCloud2>("  height,width\theader"), "header, height, width");
  EXPECT_TRUE(type_support<PointCloud2>().parse_selection("height width")->is_mask());
}

TEST(SelectionText, NamesChannelsAndRangesOfAField) {
  expect_same<PointCloud2>("header.stamp, data{x,y,z}");
  expect_same<PointCloud2>("data[rows 10:20, columns :639:2]");
  expect_same<PointCloud2>("data{intensity,x}[1::2]");
  expect_same<LaserScan>("ranges[::4]");
  expect_same<LaserScan>("ranges[7], intensities[:100]");
  EXPECT_EQ(read<LaserScan>("header.stamp, ranges[::4]"), "header.stamp, ranges[::4]");
}

TEST(SelectionText, HasOneFormForOneMeaning) {
  EXPECT_EQ(read<PointCloud2>("data{z, x ,y,x}"), "data{x,y,z}");
  EXPECT_EQ(read<PointCloud2>("data[ rows 0: , columns 0:640:2 ]"), "data[:639:2]");
  EXPECT_EQ(read<LaserScan>("ranges[3:4:9]"), "ranges[3]");
  EXPECT_EQ(read<LaserScan>("ranges[5:5]"), "ranges[0:0]");
  EXPECT_EQ(read<LaserScan>("ranges[:]"), "ranges");
  EXPECT_EQ(read<LaserScan>("ranges[:1:2]"), "ranges[0]");
  EXPECT_EQ(read<LaserScan>("ranges[1::4294967294]"), "ranges[1]");
  EXPECT_EQ(read<LaserScan>("ranges[4294967294::2]"), "ranges[4294967294]");
}

TEST(SelectionText, UnitesWhatIsSaidOfOneFieldTwice) {
  EXPECT_EQ(read<PointCloud2>("data{x}, data{y}"), "data{x,y}");
  EXPECT_EQ(read<PointCloud2>("data{x}, data"), "data");
  EXPECT_EQ(read<PointCloud2>("data{x}, *"), "*");
  EXPECT_EQ(read<LaserScan>("ranges[:10], ranges[5:]"), "ranges") << "a union of ranges is no range";
  EXPECT_EQ(read<LaserScan>("ranges[3], ranges[3:4:2]"), "ranges[3]");
  EXPECT_EQ(read<PointCloud2>("data{x}, data[1]"), "data");
  std::string again = "data{x}";
  for (int i = 0; i < 100; ++i) again += ", data{x}";
  EXPECT_EQ(read<PointCloud2>(again), "data{x}");
  for (int i = 0; i < 100; ++i) again += ", data{c" + std::to_string(i) + "}";
  EXPECT_EQ(read<PointCloud2>("height, " + again), "column 9: more than 64 channels");
  EXPECT_EQ(read<PointCloud2>(again + " *"), "*");
}

TEST(SelectionText, SaysWhenASampleIsSent) {
  expect_same<BatteryState>("percentage @ changed 1% or every 10 s");
  expect_same<BatteryState>("* @ temperature > 60");
  expect_same<BatteryState>("voltage @ at most 2 Hz");
  expect_same<BatteryState>("voltage @ every 3rd at most 2 Hz");
  expect_same<BatteryState>("voltage @ at most one per 2 min");
  expect_same<BatteryState>("voltage, current @ changed(voltage) 0.5");
  expect_same<BatteryState>("voltage @ (temperature < -5.5 or every 2nd) and present == true");
  EXPECT_EQ(read<BatteryState>("voltage @ at most 2.5 Hz"), "voltage @ at most one per 400 ms");
  EXPECT_EQ(read<BatteryState>("voltage @ every 60000 ms"), "voltage @ every 1 min");
  EXPECT_EQ(read<BatteryState>("@ every 11th"), "@ every 11th");
  EXPECT_EQ(read<BatteryState>("voltage @ changed .5"), "voltage @ changed 0.5");
  EXPECT_EQ(read<BatteryState>("* @ present == 1"), "* @ present == true");
}

TEST(SelectionText, OfConditionsHasOneFormForOneMeaning) {
  EXPECT_EQ(read<BatteryState>("* @ voltage>1 and current<2"),
            read<BatteryState>("* @ current < 2 and voltage > 1"));
  EXPECT_EQ(read<BatteryState>("* @ ((voltage > 1))"), "* @ voltage > 1");
  EXPECT_EQ(read<BatteryState>("* @ voltage > 1 or voltage > 1"), "* @ voltage > 1");
  EXPECT_EQ(read<BatteryState>("* @ (voltage > 1 or current > 2) or charge > 3"),
            read<BatteryState>("* @ voltage > 1 or (current > 2 or charge > 3)"));
  EXPECT_EQ(read<BatteryState>("voltage @ changed(voltage)"), "voltage @ changed");
  EXPECT_EQ(read<BatteryState>("voltage @ changed 0%"), "voltage @ changed");
}

TEST(SelectionText, HasOneFormForOneNumber) {
  const auto number = [](const std::string& text) {
    return read<BatteryState>("voltage @ voltage > " + text).substr(20);
  };
  for (const char* text : {"60", "60.0", "6e1", "0060.", "600E-1"}) EXPECT_EQ(number(text), "60");
  for (const char* text : {"0", "-0", "0.0", "-0.0", "-0e9"}) EXPECT_EQ(number(text), "0");
  EXPECT_EQ(number("-9223372036854775808.0"), "-9223372036854775808");
  EXPECT_EQ(number("18446744073709551615"), "18446744073709551615");
  EXPECT_EQ(number("18446744073709551615.0"), "18446744073709551616") << "the nearest double";
  EXPECT_EQ(number("18446744073709551616"), "18446744073709551616");
  EXPECT_EQ(number("-9223372036854775809"), "-9223372036854775808") << "the nearest double";
  EXPECT_EQ(number("1e300"), "1e+300");
  EXPECT_EQ(number("0.10"), "0.1");
  EXPECT_EQ(read<BatteryState>("voltage @ changed 5.0"), read<BatteryState>("voltage @ changed 5"));
}

TEST(SelectionText, TellsFieldsFromWordsOfTheSameName) {
  using Kind = StructType::Member::Kind;
  using Shape = StructType::Member::Shape;
  static constexpr EnumType::Enumerator enumerators[] = {{"off", 0}, {"true", 5}, {"false", 6}};
  static constexpr EnumType choice{"Choice", false, enumerators};
  static constexpr StructType::Member members[] = {
      {.name = "at", .kind = Kind::float64},
      {.name = "changed", .kind = Kind::float64},
      {.name = "every", .kind = Kind::float64},
      {.name = "or", .kind = Kind::float64},
      {.name = "choice", .kind = Kind::int32, .enumeration = &choice},
      {.name = "rows", .kind = Kind::int8, .shape = Shape::sequence}};
  static constexpr StructType words("Words", members);
  const TypeSupport type(words);
  for (const char* text :
       {"@ at > 1", "@ at > 1 at most 2 Hz", "@ changed > 1 and every == 3", "@ or < 0 or or > 1",
        "at @ changed", "at, changed @ changed(changed) 2 or every 3rd", "rows[1]", "@ choice == true"})
    EXPECT_EQ(read(type, text), text);
  EXPECT_EQ(read(type, "@ choice == 6"), "@ choice == false");
  EXPECT_EQ(read(type, "@ changed.x > 1"),
            "column 3: Words has no field 'changed.x'; did you mean 'changed'?");
}

TEST(SelectionText, NamesPartsOfNotTooManyFields) {
  using Kind = StructType::Member::Kind;
  using Shape = StructType::Member::Shape;
  std::vector<std::string> names;
  for (int i = 0; i < 20; ++i) names.push_back("list_" + std::to_string(i));
  std::vector<StructType::Member> members;
  for (const std::string& name : names)
    members.push_back({.name = name, .kind = Kind::int8, .shape = Shape::sequence});
  const StructType lists("Lists", members);
  const TypeSupport type(lists);
  std::string text;
  for (std::size_t i = 0; i < 16; ++i) text += (text.empty() ? "" : ", ") + names[i] + "[1]";
  EXPECT_EQ(read(type, text), text);
  EXPECT_EQ(read(type, text + ", list_16[1]"), "column 1: parts of more than 16 fields");
  EXPECT_EQ(read(type, text + ", list_16[1], list_3").substr(0, 9), "list_0[1]");
  EXPECT_EQ(read(type, text + ", list_16[1], *"), "*");
}

TEST(SelectionText, SaysWhichColumnIsWrongAndWhatIsRight) {
  EXPECT_EQ(read<LaserScan>("header rnages"),
            "column 8: sensor_msgs::msg::LaserScan has no field 'rnages'; did you mean 'ranges'?");
  EXPECT_EQ(read<LaserScan>("ranges[::0]"), "column 10: a step of 0 keeps nothing; steps count from 1");
  EXPECT_EQ(read<LaserScan>("ranges[-3:]"), "column 8: indices count from 0 on, from the front");
  EXPECT_EQ(read<LaserScan>("ranges[4294967295]"), "column 8: this index is too large");
  EXPECT_EQ(read<LaserScan>("ranges[9:3]"), "column 8: a range ends behind its begin");
  EXPECT_EQ(read<LaserScan>("ranges[1"), "column 9: ']' is missing behind the part");
  EXPECT_EQ(read<LaserScan>("angle_min[1]"),
            "column 1: 'angle_min' has no parts; only a list of values has some");
  EXPECT_EQ(read<PointCloud2>("fields[].name{x}"),
            "column 1: 'fields[].name' is inside an array or a list; only fields outside these have parts");
  EXPECT_EQ(read<PointCloud2>("data{x,}"), "column 8: here a channel is named");
  EXPECT_EQ(read<PointCloud2>("data{x"), "column 7: '}' is missing behind the channels");
  EXPECT_EQ(read<PointCloud2>("data[rows 1, rows 2]"), "column 14: this is said already");
  EXPECT_EQ(read<LaserScan>("ranges{x}"), "column 7: 'ranges' has no channels");
  EXPECT_EQ(read<Image>("data[rows 1]{x}"), "column 13: behind a part stands a comma or a blank");
  EXPECT_EQ(read<Image>("data{x}"), "column 5: 'data' has no channels");
  EXPECT_EQ(read<LaserScan>("ranges[columns 3]"),
            "column 8: this field has elements, and no rows and columns; leave out the word");
  EXPECT_EQ(
      read<Imu>("orientation_covariance[::4]"),
      "column 1: 'orientation_covariance' has no parts; an array has a fixed length, and is always whole");
  EXPECT_EQ(read<PointCloud2>("data[rows 1, 2]"), "column 14: behind rows stand columns: 'columns 1:5'");
  EXPECT_EQ(read<PointCloud2>("data{x}height"), "column 8: behind a part stands a comma or a blank");
  EXPECT_EQ(read<BatteryState>("* @ temperature"), "column 16: behind a field stands <, <=, >, >=, == or !=");
  EXPECT_EQ(read<BatteryState>("* @ temperature > warm"), "column 19: here a number is needed, not 'warm'");
  EXPECT_EQ(read<BatteryState>("* @ temperature > true"), "column 19: here a number is needed, not 'true'");
  EXPECT_EQ(read<BatteryState>("* @ temperature > nan"), "column 19: here a number is needed, not 'nan'");
  EXPECT_EQ(read<BatteryState>("* @ temperature > -inf"), "column 19: a number is a finite number");
  EXPECT_EQ(read<BatteryState>("* @ temperature > 1e999"), "column 19: a number is a finite number");
  EXPECT_EQ(read<BatteryState>("* @ changed inf"),
            "column 13: behind a condition stands 'and', 'or' or 'at most'");
  EXPECT_EQ(read<BatteryState>("* @ at most 1e-320 Hz"),
            "column 13: a rate is from one in 24 hours to 1000000 Hz");
  EXPECT_EQ(read<BatteryState>("* @ changed nan"),
            "column 13: behind a condition stands 'and', 'or' or 'at most'");
  EXPECT_EQ(read<BatteryState>("voltage @ changed -1"), "column 19: a deadband is a finite number from 0 on");
  EXPECT_EQ(read<BatteryState>("* @ every 0th"), "column 11: samples are counted from the 1st on");
  EXPECT_EQ(read<BatteryState>("* @ every 2 days"), "column 13: behind a period stands us, ms, s or min");
  EXPECT_EQ(read<BatteryState>("* @ at most 0 Hz"),
            "column 13: a rate is from one in 24 hours to 1000000 Hz");
  EXPECT_EQ(read<BatteryState>("* @ header > 1"), "column 5: 'header' is not a single value");
  EXPECT_EQ(read<BatteryState>("* @ location == 1"), "column 17: texts are not compared; use 'changed'");
  EXPECT_EQ(read<BatteryState>("* @ ("),
            "column 6: here a condition is needed: a field, 'changed' or 'every'");
}

TEST(SelectionText, IsBounded) {
  std::string conditions = "* @ voltage > 0";
  for (int i = 1; i < 31; ++i) conditions += " or voltage > " + std::to_string(i);
  EXPECT_EQ(read<BatteryState>(conditions).substr(0, 3), "* @") << "31 and the 'or'";
  EXPECT_NE(read<BatteryState>(conditions + " or voltage > 31").find("more than 32 conditions"),
            std::string::npos);
  for (int i = 31; i < 40; ++i) {
    conditions += " or voltage > " + std::to_string(i);
    EXPECT_EQ(read<BatteryState>(conditions), "column 4: more than 32 conditions");
  }
  std::string same = "* @ voltage > 0";
  for (int i = 1; i < 50; ++i) same += " or voltage > 0";
  EXPECT_EQ(read<BatteryState>(same), "* @ voltage > 0");
  EXPECT_EQ(read<BatteryState>("* @ " + std::string(100'000, '(')),
            "column 12: conditions lie at most 8 deep in each other");
  std::string channels = "data{c0";
  for (int i = 1; i < 64; ++i) channels += ",c" + std::to_string(i);
  EXPECT_EQ(read<PointCloud2>(channels + "}").substr(0, 5), "data{");
  EXPECT_EQ(read<PointCloud2>(channels + ",d}"), "column 1: more than 64 channels");
  EXPECT_EQ(read<PointCloud2>("data{" + std::string(256, 'x') + "}"),
            "column 1: the name of a channel has 1 to 255 bytes");
}

}  // namespace
}  // namespace sft
