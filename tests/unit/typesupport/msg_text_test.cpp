// Types as .msg text, which is written and read back, or read from files.
#include "sft/msg_text.h"

#include <unistd.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <std_msgs/msg/Empty.hpp>
#include <std_srvs/srv/SetBool.hpp>
#include <string>
#include <torture.hpp>
#include <vector>

#include "sft/detail/type_description.h"
#include "sft/detail/type_shape.h"
#include "tests/support/message_types.h"

namespace sft {
namespace {

using namespace detail;

using sensor_msgs::msg::PointCloud2;
using ::testing::HasSubstr;
using ::testing::StartsWith;

namespace fs = std::filesystem;

const std::string separator = std::string(80, '=') + "\n";

template <class T>
DynamicType type_of() {
  return DynamicType::parse(describe(TypeTable<T>::type)).value();
}

std::string fault(std::string_view text, std::string_view name = "my_msgs/Example") {
  const auto type = from_msg(name, text);
  return type ? "" : type.error().message;
}

TEST(MsgTextTest, IsTheMessageAndBehindItThoseThatItNests) {
  EXPECT_EQ(to_msg(type_of<PointCloud2>()).value(),
            "std_msgs/Header header\n"
            "uint32 height\n"
            "uint32 width\n"
            "sensor_msgs/PointField[] fields\n"
            "bool is_bigendian\n"
            "uint32 point_step  # [byte]\n"
            "uint32 row_step  # [byte]\n"
            "uint8[] data\n"
            "bool is_dense\n" +
                separator +
                "MSG: std_msgs/Header\n"
                "builtin_interfaces/Time stamp\n"
                "string frame_id\n" +
                separator +
                "MSG: sensor_msgs/PointField\n"
                "string name\n"
                "uint32 offset  # [byte]\n"
                "uint8 datatype\n"
                "uint32 count\n" +
                separator +
                "MSG: builtin_interfaces/Time\n"
                "int32 sec  # [s]\n"
                "uint32 nanosec  # [ns]\n");
}

TEST(MsgTextTest, OfEveryTypeOfTheCommonPackagesTheSameTypeComesBack) {
  std::size_t of_messages = 0;
  for (const test::MessageType& each : test::every_type()) {
    const DynamicType type = DynamicType::parse(describe(each.support->type())).value();
    const auto text = to_msg(type);
    if (!text) continue;
    ++of_messages;
    const auto back = from_msg(type.name(), *text);
    ASSERT_TRUE(back) << back.error().message << "\n" << *text;
    EXPECT_EQ(back->hash(), type.hash()) << first_difference(back->type(), type.type());
    EXPECT_EQ(back->name(), type.name());
  }
  EXPECT_GE(of_messages, 120U);
}

TEST(MsgTextTest, AMessageWithoutFieldsIsAnEmptyText) {
  EXPECT_EQ(to_msg(type_of<std_msgs::msg::Empty>()).value(), "");
  EXPECT_EQ(from_msg("std_msgs/msg/Empty", "")->hash(), type_of<std_msgs::msg::Empty>().hash());
}

TEST(MsgTextTest, ConstantsDefaultsCommentsAndReturnsAreReadOver) {
  const auto type = from_msg("my_msgs::msg::Example",
                             "# An example\r\nint32 LIMIT=5\r\nint32[<=5] numbers [1, 2]  # [m]\r\n"
                             "=====\r\nMSG: other_msgs/Unused\r\nbool x\r\n");
  ASSERT_TRUE(type) << type.error().message;
  EXPECT_EQ(format_shape(type->type()),
            "struct my_msgs::msg::Example {\n  @unit(\"m\") sequence<int32, 5> numbers;\n};\n");
}

TEST(MsgTextTest, WhatIsWrongIsSaidWithMessageLineAndField) {
  EXPECT_THAT(fault("int32 x\nint31 y\n"), HasSubstr("my_msgs/msg/Example:2: y: 'int31' is not a type"));
  EXPECT_THAT(fault("Point p\n" + separator + "MSG: my_msgs/Point\nfloat64 X\n"),
              HasSubstr("my_msgs/msg/Point:1: "));
  EXPECT_THAT(fault("geometry_msgs/Point p\n"),
              HasSubstr("geometry_msgs/msg/Point is not defined: append its definition"));
  EXPECT_EQ(fault("Example e\n"), "my_msgs/msg/Example contains itself");
  EXPECT_EQ(fault("int32 x\n" + separator + "MSG: my_msgs/Example\nint32 x\n"),
            "my_msgs/msg/Example is defined twice");
  EXPECT_THAT(fault("int32 x\n" + separator + "int32 y\n"),
              HasSubstr("a line 'MSG: package/Name' was expected, not 'int32 y'"));
  EXPECT_THAT(fault("int32 x\n" + separator), HasSubstr("was expected"));
  EXPECT_THAT(fault("int32 x", "Example"), HasSubstr("the name of a message is expected"));
}

TEST(MsgTextTest, MessagesAreNestedOverALimitedNumberOfLevels) {
  const auto nested = [](int levels) {
    std::string text = levels > 1 ? "L2 inner\n" : "int32 x\n";
    for (int level = 2; level <= levels; ++level) {
      text += separator + "MSG: my_msgs/L" + std::to_string(level) + "\n" +
              (level < levels ? "L" + std::to_string(level + 1) + " inner\n" : "int32 x\n");
    }
    return fault(text);
  };
  EXPECT_EQ(nested(32), "");
  EXPECT_THAT(nested(33),
              HasSubstr("my_msgs/msg/Example: 'my_msgs::msg::Example' has, with member 'inner', more "
                        "than 32 structs in one another"));
  EXPECT_THAT(nested(256), HasSubstr("more than 32 structs in one another"));
  EXPECT_EQ(nested(257), "messages are nested over more than 256 levels");
}

TEST(MsgTextTest, AnyNumberOfMessagesMayStandBesideEachOther) {
  std::string fields, definitions;
  for (int i = 0; i < 300; ++i) {
    const std::string number = std::to_string(i);
    fields += "Beside" + number + " field" + number + "\n";
    definitions += separator + "MSG: my_msgs/Beside" + number + "\nint32 x\n";
  }
  EXPECT_EQ(fault(fields + definitions), "");
}

TEST(MsgTextTest, AUnitThatACommentWouldTellOtherwiseIsLeftOut) {
  const auto text_with = [](std::string_view unit) {
    const Member member{.name = "x", .kind = Kind::int32, .unit = unit};
    const StructType type("my_msgs::msg::Example", {&member, 1});
    return to_msg(DynamicType::parse(describe(type)).value()).value();
  };
  EXPECT_EQ(text_with("m/s"), "int32 x  # [m/s]\n");
  for (const char* unit : {"m, s", "[m", "m]"}) EXPECT_EQ(text_with(unit), "int32 x\n") << unit;
}

TEST(MsgTextTest, WhatMsgHasNoWordForIsAnErrorThatNamesTheMember) {
  const auto text = to_msg(type_of<torture::Sequences>());
  ASSERT_FALSE(text);
  EXPECT_EQ(text.error().code, Errc::invalid_argument);
  EXPECT_THAT(text.error().message, HasSubstr("torture::Sequences"));
}

TEST(MsgFileTest, EveryMessageOfTheCommonPackagesIsFoundByItsName) {
  const std::vector<fs::path> roots{SFT_INTERFACES};
  std::size_t found = 0;
  for (const test::MessageType& each : test::every_type()) {
    const std::string name(each.support->name());
    const fs::path package = name.substr(0, name.find("::"));
    if (name.find("::msg::") == name.npos) continue;  // skips the parts of services
    if (!fs::exists(roots[0] / package / "msg" / (each.short_name() + ".msg"))) continue;
    ++found;
    const auto type = find_msg(name, roots);
    ASSERT_TRUE(type) << type.error().message;
    EXPECT_EQ(type->hash(), each.support->hash()) << name;
  }
  EXPECT_GT(found, 100U);
  EXPECT_EQ(find_msg("sensor_msgs/PointCloud2", roots)->hash(), type_of<PointCloud2>().hash());
}

TEST(MsgFileTest, TheMessagesOfAServiceAreThoseOfItsGeneratedHeader) {
  using std_srvs::srv::SetBool;
  const std::vector<fs::path> roots{SFT_INTERFACES};
  const auto hash_of = [&](const char* part) {
    return find_msg(std::string("std_srvs/srv/SetBool_") + part, roots).map(&DynamicType::hash);
  };
  EXPECT_EQ(hash_of("Request"), type_of<SetBool::Request>().hash());
  EXPECT_EQ(hash_of("Response"), type_of<SetBool::Response>().hash());
  EXPECT_EQ(hash_of("Call"), type_of<SetBool::Call>().hash());
  EXPECT_EQ(hash_of("Reply"), type_of<SetBool::Reply>().hash());
  EXPECT_EQ(find_msg("std_srvs/srv/SetBool_Call", roots)->name(), "std_srvs::srv::SetBool_Call");
  EXPECT_EQ(hash_of("Goal").error().code, Errc::invalid_argument);
  EXPECT_EQ(find_msg("std_srvs/srv/Sing_Call", roots).error().message,
            "there is no std_srvs/srv/Sing.srv below " SFT_INTERFACES
            ": name the directory above its package, too");
}

/// Packages in a temporary directory. The destructor removes the directory.
class OwnPackages {
 public:
  OwnPackages() { fs::create_directories(root_ / "my_msgs" / "msg"); }
  ~OwnPackages() { fs::remove_all(root_); }
  OwnPackages(const OwnPackages&) = delete;
  OwnPackages& operator=(const OwnPackages&) = delete;

  fs::path write(const std::string& name, const std::string& text) const {
    const fs::path file = root_ / "my_msgs" / "msg" / name;
    std::ofstream(file) << text;
    return file;
  }
  const fs::path& root() const { return root_; }

 private:
  fs::path root_ = fs::temp_directory_path() / ("sft_msg_files_" + std::to_string(getpid()));
};

TEST(MsgFileTest, WhatAFileNestsIsLookedForBesideItAndBelowTheRoots) {
  const OwnPackages own;
  own.write("Cell.msg", "float32 volts\n");
  const fs::path file = own.write("Battery.msg", "std_msgs/Header header\nCell[] cells\n");
  const auto type = from_msg_file(file, std::vector<fs::path>{SFT_INTERFACES});
  ASSERT_TRUE(type) << type.error().message;
  EXPECT_EQ(type->name(), "my_msgs::msg::Battery");
  EXPECT_EQ(type->support().path(type->support().leaves() - 1), "cells[].volts");
  EXPECT_EQ(from_msg_file(file).error().message, "there is no std_msgs/msg/Header.msg below " +
                                                     own.root().string() +
                                                     ": name the directory above its package, too");
}

TEST(MsgFileTest, WhatIsWrongIsSaidWithTheFile) {
  const OwnPackages own;
  const fs::path file = own.write("Bad.msg", "float32 ok\nflaot32 speed\n");
  EXPECT_THAT(from_msg_file(file).error().message, StartsWith(file.string() + ":2: "));
  EXPECT_EQ(from_msg_file("Bad.msg").error().message,
            "the path of a message is expected, PACKAGE/msg/NAME.msg, not 'Bad.msg'");
  EXPECT_EQ(from_msg_file(own.root() / "my_msgs/msg/None.msg").error().code, Errc::unavailable);
  const fs::path loop = own.write("Loop.msg", "Loop[] inner\n");
  EXPECT_EQ(from_msg_file(loop).error().message, "my_msgs/msg/Loop contains itself");
}

}  // namespace
}  // namespace sft
