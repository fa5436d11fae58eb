// Texts of .srv files: the two messages, their lines, and the problems of wrong texts.
#include "from_msg/service.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "from_msg/parse.h"

namespace sft::msg {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::vector<Definition> service_of(std::string_view text) {
  auto result = parse_service(text, {"my_msgs", "SetMode", "srv"});
  if (result) return *std::move(result);
  ADD_FAILURE() << text << ": " << result.error().front().text;
  return std::vector<Definition>(4);
}

/// Returns each problem as "LINE: TEXT".
std::string service_problems(std::string_view text, const std::string& name = "SetMode",
                             const std::string& package = "my_msgs") {
  std::string lines;
  const auto result = parse_service(text, {package, name, "srv"});
  if (result) return lines;
  for (const Problem& problem : result.error())
    lines += (lines.empty() ? "" : "\n") + std::to_string(problem.line) + ": " + problem.text;
  return lines;
}

std::vector<std::string> field_names(const Definition& definition) {
  std::vector<std::string> result;
  for (const Field& field : definition.fields) result.push_back(field.name);
  return result;
}

TEST(Services, AreTwoMessagesAndTheTwoThatCarryThem) {
  const auto all = service_of("uint8 OFF=0\nuint8 mode\n---\nbool success\nstring message\n");
  ASSERT_EQ(all.size(), 4U);
  EXPECT_EQ(all[0].type.text(), "my_msgs/srv/SetMode_Request");
  EXPECT_EQ(all[1].type.text(), "my_msgs/srv/SetMode_Response");
  EXPECT_EQ(all[2].type.text(), "my_msgs/srv/SetMode_Call");
  EXPECT_EQ(all[3].type.text(), "my_msgs/srv/SetMode_Reply");
  EXPECT_EQ(all[0].constants.size(), 1U);
  EXPECT_THAT(field_names(all[0]), ElementsAre("mode"));
  EXPECT_THAT(field_names(all[1]), ElementsAre("success", "message"));
  EXPECT_THAT(field_names(all[2]), ElementsAre("client", "number", "server", "timeout_ms", "request"));
  EXPECT_THAT(field_names(all[3]), ElementsAre("client", "number", "server", "error", "response"));
  EXPECT_EQ(all[2].fields.back().type.nested, all[0].type);
  EXPECT_EQ(all[3].fields.back().type.nested, all[1].type);
}

TEST(Services, PartsMayBeEmpty) {
  for (const char* text : {"---", "---\n", "# nothing\n---\n# nothing\n", "\r\n---\r\n"}) {
    const auto all = service_of(text);
    EXPECT_EQ(all[0].fields.size(), 1U) << "as in ROS 2";
    EXPECT_EQ(all[1].fields.size(), 1U);
  }
}

TEST(Services, TypesWithoutAPackageAreMessagesOfTheirPackage) {
  EXPECT_EQ(service_of("Mode mode\n---\n")[0].fields[0].type.nested, (TypeName{"my_msgs", "Mode"}));
}

TEST(Services, CommentsBelongToThePartInWhichTheyStand) {
  const auto all =
      service_of("# [m]\n\nfloat64 speed  # [m/s]\n---\n# about the response [s]\nfloat64 length # [m]\n");
  EXPECT_EQ(all[0].fields[0].unit, "m/s");
  EXPECT_EQ(all[1].fields[0].unit, "m");
}

TEST(Services, ProblemsHaveTheirLinesInTheFile) {
  EXPECT_THAT(service_problems("int32 x\n---\nbool ok\nwstring w\n"), HasSubstr("4: wide characters"));
  EXPECT_EQ(service_problems("double x\n---\nint y\n").find("1: 'double'"), 0U);
  EXPECT_THAT(service_problems("double x\n---\nint y\n"), HasSubstr("\n3: 'int'"));
  EXPECT_EQ(service_problems("int8 x\n---\n\nint8 y\nint8 y\n"),
            "5: there is one already, in line 4: rename one of them");
  EXPECT_EQ(service_problems("int8 x\n---\nint8 y # gr\xFC\xDF"), "3: this is not UTF-8: convert the file");
}

TEST(Services, HaveOneLineBetweenTheirParts) {
  EXPECT_EQ(service_problems("int32 x\n"), "2: there is no line '---' between the request and the response");
  EXPECT_EQ(service_problems("int32 x"), "1: there is no line '---' between the request and the response");
  EXPECT_EQ(service_problems(""), "1: there is no line '---' between the request and the response");
  EXPECT_EQ(service_problems("--- \n"), "2: there is no line '---' between the request and the response")
      << "as in ROS 2";
  EXPECT_THAT(service_problems("---\nint32 x\n---\n"),
              HasSubstr("3: a second line '---': a service has two parts; actions"));
  EXPECT_THAT(service_problems("int8 x\n----\n---\n"),
              HasSubstr("2: '---' separates the two parts of a service"));
}

TEST(Services, HaveNamesOfOneWord) {
  EXPECT_EQ(service_problems("---", "set_mode"),
            "1: 'set_mode' is not a service name: expected a capital letter, then letters and digits, as in "
            "SetMode");
  EXPECT_NE(service_problems("---", "SetMode_Request"), "");
  EXPECT_THAT(service_problems("---", "SetMode", "MyMsgs"), HasSubstr("'MyMsgs' is not a package name"));
}

TEST(Services, AreOfLimitedSize) {
  EXPECT_EQ(service_problems("---\n" + std::string(Limits::bytes - 4, '\n')), "");
  EXPECT_THAT(service_problems("---\n" + std::string(Limits::bytes - 3, '\n')),
              HasSubstr("at most 1048576 bytes"));
}

}  // namespace
}  // namespace sft::msg
