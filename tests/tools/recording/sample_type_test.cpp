// The types of samples in recordings.
#include "tools/recording/sample_type.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <filesystem>

#include "sft/msg_text.h"
#include "tools/recording/open_recording.h"

namespace sft::recording {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

DynamicType installed(std::string_view name) {
  const std::array<std::filesystem::path, 1> roots{SFT_TEST_INTERFACES};
  return find_msg(name, roots).value();
}

/// The type in a file of samples with this selection.
SampleType stored(std::string_view name, std::string_view selection) {
  const DynamicType type = installed(name);
  return sample_type(type, selection_of(type, selection).value().mask()).value();
}

TEST(SampleTypeTest, AWholeMessageHasItsOwnType) {
  const SampleType type = stored("sensor_msgs/PointCloud2", "*");
  EXPECT_EQ(type.name, "sensor_msgs/msg/PointCloud2");
  EXPECT_EQ(from_msg(type.name, type.definition).value().hash(), installed("sensor_msgs/PointCloud2").hash());
}

TEST(SampleTypeTest, ChosenFieldsHaveATypeWithJustThese) {
  const SampleType type = stored("sensor_msgs/PointCloud2", "header.stamp.sec, width, fields[].name");
  EXPECT_THAT(type.name, ::testing::MatchesRegex("sensor_msgs/msg/PointCloud2Part[0-9a-f]+"));
  EXPECT_THAT(type.definition, Not(HasSubstr("height")));
  const DynamicType read = from_msg(type.name, type.definition).value();
  EXPECT_EQ(read.support().format_mask(read.support().full()), "*");
  std::vector<std::string> paths;
  for (std::size_t i = 0; i < read.support().leaves(); ++i) paths.push_back(read.support().path(i));
  EXPECT_EQ(paths, (std::vector<std::string>{"header.stamp.sec", "width", "fields.size", "fields[].name"}));
}

TEST(SampleTypeTest, TheExampleOfTheDocumentIsTrue) {
  const SampleType type = stored("sensor_msgs/PointCloud2", "header.stamp, width");
  EXPECT_EQ(type.name, "sensor_msgs/msg/PointCloud2Part13");
  EXPECT_THAT(type.definition, ::testing::StartsWith("std_msgs/HeaderPart3 header\nuint32 width\n====="));
  EXPECT_THAT(type.definition, HasSubstr("MSG: std_msgs/HeaderPart3\nbuiltin_interfaces/Time stamp\n====="));
}

TEST(SampleTypeTest, OnlyTheLengthOfASequenceIsANumber) {
  const SampleType type = stored("sensor_msgs/PointCloud2", "fields.size");
  EXPECT_EQ(type.definition, "uint32 fields_size\n");
}

TEST(SampleTypeTest, OneNestedTypeWithDifferentFieldsHasTwoNames) {
  const SampleType type = stored("geometry_msgs/Twist", "linear.x, angular.z");
  EXPECT_THAT(type.definition, HasSubstr("geometry_msgs/Vector3Part1 linear\n"));
  EXPECT_THAT(type.definition, HasSubstr("geometry_msgs/Vector3Part4 angular\n"));
  EXPECT_TRUE(from_msg(type.name, type.definition));
}

TEST(SampleTypeTest, EqualSelectionsHaveEqualNamesAndOthersOtherNames) {
  EXPECT_EQ(stored("sensor_msgs/Imu", "header, orientation").name,
            stored("sensor_msgs/Imu", "orientation header").name);
  EXPECT_NE(stored("sensor_msgs/Imu", "header, orientation").name, stored("sensor_msgs/Imu", "header").name);
}

TEST(SampleTypeTest, PartsAloneComeWithTheRestOfTheMessage) {
  for (const auto& [name, text] : {std::pair("sensor_msgs/PointCloud2", "data{x,y,z}[::2]"),
                                   std::pair("sensor_msgs/LaserScan", "ranges[::4]"),
                                   std::pair("sensor_msgs/Image", "data[rows 0:10, columns 0:10]")}) {
    const DynamicType type = installed(name);
    const Selection selection = selection_of(type, text).value();
    EXPECT_TRUE(selection.mask().is_full()) << name;
    const std::size_t leaf = *type.support().parse_selection(text).value().mask().begin();
    EXPECT_NE(selection.part(leaf), nullptr) << name << ": it is still a part";
  }
  const DynamicType scan = installed("sensor_msgs/LaserScan");
  EXPECT_EQ(selection_of(scan, "ranges[::4]").value().parts().size(), 2U) << "intensities have the same part";
}

TEST(SampleTypeTest, PartsBesideWholeFieldsAreJustThese) {
  const DynamicType type = installed("sensor_msgs/PointCloud2");
  const Selection selection = selection_of(type, "header.stamp, data{x}").value();
  EXPECT_FALSE(selection.mask().is_full());
  EXPECT_EQ(selection.parts().size(), 1U);
}

TEST(SampleTypeTest, AConditionAloneSelectsAllFields) {
  const DynamicType type = installed("sensor_msgs/BatteryState");
  const Selection selection = selection_of(type, " @ changed(voltage) 1%").value();
  EXPECT_TRUE(selection.mask().is_full());
  EXPECT_FALSE(selection.gate().is_open());
}

TEST(SampleTypeTest, AWrongFieldIsNamed) {
  const auto selection = selection_of(installed("sensor_msgs/Imu"), "orientatoin");
  ASSERT_FALSE(selection);
  EXPECT_THAT(selection.error().message, HasSubstr("orientation"));
}

TEST(IdlTextTest, TheIdlThatRos2MakesOfAMessageIsTheSameType) {
  constexpr const char* text =
      R"(================================================================================
IDL: my_msgs/msg/Status
// generated from rosidl_adapter/resource/msg.idl.em
#include "builtin_interfaces/msg/Time.idl"

module my_msgs {
  module msg {
    typedef double double__3[3];
    module Status_Constants {
      @verbatim (language="comment", text= "a \"constant\" with ) and }")
      const uint8 LEVEL = 1;
    };
    @verbatim (language="comment", text=
      "A message.")
    struct Status {
      builtin_interfaces::msg::Time stamp;
      @unit (value="m")
      double__3 position;
      sequence<my_msgs::msg::Part, 4> parts;
      sequence<float> ranges;
      string<8> name;
      @default (value=TRUE)
      boolean ok;
      unsigned long long count;
      octet raw;
    };
  };
};
================================================================================
IDL: builtin_interfaces/msg/Time
module builtin_interfaces { module msg { struct Time { int32 sec; uint32 nanosec; }; }; };
================================================================================
IDL: my_msgs/msg/Part
module my_msgs { module msg { struct Part { short number; /* comment */ long other; }; }; };
)";
  const Schema schema{.name = "my_msgs/msg/Status", .encoding = "ros2idl", .data = text};
  const Result<DynamicType> type = type_of(schema);
  ASSERT_TRUE(type) << type.error().message;
  constexpr const char* same =
      "builtin_interfaces/Time stamp\nfloat64[3] position\nPart[<=4] parts\nfloat32[] ranges\nstring<=8 "
      "name\n"
      "bool ok\nuint64 count\nbyte raw\n===\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
      "===\nMSG: my_msgs/Part\nint16 number\nint32 other\n";
  EXPECT_EQ(type->hash(), from_msg("my_msgs/Status", same).value().hash());
}

TEST(IdlTextTest, AliasesOfAliasesTakeNoMemory) {
  std::string text = "typedef string<1> a0;\n";
  for (int i = 0; i < 1000; ++i)
    text += "typedef a" + std::to_string(i) + " a" + std::to_string(i + 1) + "[1];\n";
  const auto type = type_of({.name = "m/msg/T", .encoding = "ros2idl", .data = text});
  ASSERT_FALSE(type);
  EXPECT_THAT(type.error().message, HasSubstr("a type has more than 512 characters"));
}

TEST(IdlTextTest, OtherIdlIsNamed) {
  for (const char* const text :
       {"", "module m { module msg { enum E { A }; }; };", "module m {", "struct S { long", "@a(((",
        "module m { module msg { struct T { sequence<T> a; }; }; };"}) {
    const auto type = type_of({.name = "m/msg/T", .encoding = "ros2idl", .data = text});
    EXPECT_FALSE(type) << text;
  }
}

}  // namespace
}  // namespace sft::recording
