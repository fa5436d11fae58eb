// Names of nodes and topics: namespaces, private names and remapping rules.
#include "core/names/remapping.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace sft::core {
namespace {

using Rules = std::vector<std::string>;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

Remapping left_cam(const Rules& rules = {}, const char* environment = nullptr) {
  return Remapping::of({.name = "cam", .namespace_ = "/left", .remap = rules}, environment).value();
}

std::string resolved(const Remapping& names, std::string_view given) {
  return names.topic(given).value().topic;
}

TEST(RemappingTest, WithoutANamespaceASlashInFrontCountsForNothing) {
  const Remapping names = Remapping::of({.name = "cam"}, nullptr).value();
  EXPECT_EQ(names.node(), "cam");
  EXPECT_EQ(resolved(names, "points"), "points");
  EXPECT_EQ(resolved(names, "/points"), "points");
  EXPECT_EQ(resolved(names, "~/points"), "cam/points");
  EXPECT_EQ(resolved(names, "~"), "cam");
  EXPECT_EQ(names.topic("/points")->given, "") << "that is no other name";
}

TEST(RemappingTest, RelativeNamesAreInTheNamespaceAndPrivateOnesInTheNode) {
  const Remapping names = left_cam();
  EXPECT_EQ(names.node(), "left/cam");
  EXPECT_EQ(resolved(names, "image"), "left/image");
  EXPECT_EQ(resolved(names, "image/raw"), "left/image/raw");
  EXPECT_EQ(resolved(names, "~/image"), "left/cam/image");
  EXPECT_EQ(resolved(names, "cam"), "left/cam");
  EXPECT_EQ(resolved(names, "/clock"), "clock") << "absolute names stay";
  EXPECT_EQ(names.topic("~/image")->given, "~/image");
  EXPECT_EQ(names.topic("/clock")->given, "");
}

struct Case {
  Rules rules;
  const char* given;
  const char* topic;
};

class RuleTest : public ::testing::TestWithParam<Case> {};

TEST_P(RuleTest, AppliesToTheFullNameInANodeCamInTheNamespaceLeft) {
  EXPECT_EQ(resolved(left_cam(GetParam().rules), GetParam().given), GetParam().topic);
}

INSTANTIATE_TEST_SUITE_P(
    All, RuleTest,
    ::testing::Values(
        // Both names of a rule may be relative, absolute or private.
        Case{{"image:=raw"}, "image", "left/raw"}, Case{{"image:=raw"}, "/left/image", "left/raw"},
        Case{{"image:=raw"}, "/image", "image"}, Case{{"image:=/raw"}, "image", "raw"},
        Case{{"/left/image:=raw"}, "image", "left/raw"}, Case{{"/image:=raw"}, "image", "left/image"},
        Case{{"/clock:=/sim/clock"}, "/clock", "sim/clock"}, Case{{"clock:=x"}, "/clock", "clock"},
        Case{{"~/image:=raw"}, "~/image", "left/raw"}, Case{{"~/image:=raw"}, "cam/image", "left/raw"},
        Case{{"~/image:=raw"}, "image", "left/image"}, Case{{"image:=~/raw"}, "image", "left/cam/raw"},
        // A topic with the name of the node is an ordinary topic.
        Case{{"cam:=b"}, "cam", "left/b"}, Case{{"cam:=b"}, "~/image", "left/cam/image"},
        Case{{"~:=b"}, "cam", "left/b"},
        // A rule must match the whole name, not only its beginning.
        Case{{"image:=raw"}, "image/info", "left/image/info"}, Case{{"im:=raw"}, "image", "left/image"},
        // Only the first rule that matches is applied, and its result is not remapped again.
        Case{{"a:=b", "b:=c"}, "a", "left/b"}, Case{{"a:=b", "b:=a"}, "b", "left/a"},
        Case{{"a:=b", "a:=c"}, "a", "left/b"}, Case{{"x:=y", "a:=c"}, "a", "left/c"},
        // The following rules apply to one node only.
        Case{{"cam:a:=b"}, "a", "left/b"}, Case{{"/left/cam:a:=b"}, "a", "left/b"},
        Case{{"left/cam:a:=b"}, "a", "left/b"}, Case{{"/cam:a:=b"}, "a", "left/a"},
        Case{{"/right/cam:a:=b"}, "a", "left/a"}, Case{{"lidar:a:=b"}, "a", "left/a"},
        Case{{"lidar:a:=b", "a:=c"}, "a", "left/c"},
        // The following rules are for the name and the namespace of the node.
        Case{{"__ns:=/right"}, "a", "right/a"}, Case{{"__ns:=right"}, "a", "right/a"},
        Case{{"__ns:=/"}, "a", "a"}, Case{{"__ns:=/a/b"}, "~/x", "a/b/cam/x"},
        Case{{"__node:=eye"}, "~/x", "left/eye/x"}, Case{{"__name:=eye"}, "~/x", "left/eye/x"},
        Case{{"lidar:__node:=eye"}, "~/x", "left/cam/x"},
        Case{{"/left/cam:__node:=eye"}, "~/x", "left/eye/x"},
        Case{{"__node:=eye", "__node:=nose"}, "~/x", "left/eye/x"},
        // Rules for topics are matched against the names of the node after rules for the name and the
        // namespace have been applied, whatever the order of the rules.
        Case{{"a:=b", "__ns:=/right"}, "a", "right/b"}, Case{{"~/x:=b", "__node:=eye"}, "~/x", "left/b"},
        Case{{"/right/eye:a:=b", "__ns:=/right", "__node:=eye"}, "a", "right/b"}));

TEST(RemappingTest, TheRulesOfTheEnvironmentStandBeforeThoseOfTheProgram) {
  const Remapping names = left_cam({"a:=c", "x:=y"}, " a:=b\t__ns:=/right\n");
  EXPECT_EQ(names.node(), "right/cam");
  EXPECT_EQ(resolved(names, "a"), "right/b");
  EXPECT_EQ(resolved(names, "x"), "right/y");
  EXPECT_THAT(names.rules(), ElementsAre("a:=b", "__ns:=/right", "a:=c", "x:=y"));
  EXPECT_EQ(resolved(left_cam({}, ""), "a"), "left/a");
}

TEST(RemappingTest, AllRulesThatFitAreNamedAndTheFirstOneIsApplied) {
  const Remapping names = left_cam({"a:=b", "/left/a:=c", "x:=y", "__ns:=/left", "lidar:__node:=x"});
  EXPECT_THAT(names.topic("a")->rules, ElementsAre("a:=b", "/left/a:=c"));
  EXPECT_EQ(names.topic("a")->given, "a");
  EXPECT_TRUE(names.topic("b")->rules.empty());
  EXPECT_THAT(names.rules_of_node(), ElementsAre("__ns:=/left"));
}

TEST(RemappingTest, ARuleForTheNameOfAServiceIsForBothOfItsTopics) {
  const Remapping names =
      left_cam({"lights:=/house/lights", "lights/reply:=x", "~/on:=" + std::string(240, 'x')});
  const auto in_service = [&](const char* given, const char* type) {
    return names.topic(given, type)->topic;
  };
  EXPECT_EQ(in_service("lights/call", "std_srvs::srv::SetBool_Call"), "house/lights/call");
  EXPECT_EQ(in_service("lights/reply", "std_srvs::srv::SetBool_Reply"), "house/lights/reply")
      << "the first rule counts";
  EXPECT_EQ(in_service("lights/call", "std_msgs::msg::Bool"), "left/lights/call");
  EXPECT_EQ(in_service("lights/call", "std_srvs::srv::SetBool_Reply"), "left/lights/call");
  EXPECT_EQ(in_service("lights/call", "phone_msgs::msg::Missed_Call"), "left/lights/call");
  EXPECT_EQ(in_service("more/lights/call", "std_srvs::srv::SetBool_Call"), "left/more/lights/call");
  EXPECT_THAT(names.topic("~/on/call", "std_srvs::srv::SetBool_Call").error().message,
              HasSubstr("renames, has more than 246 characters"));
}

TEST(RemappingTest, AnErrorAboutARemappedTopicHasBothNames) {
  const TopicName name = left_cam({"~/image:=raw"}).topic("~/image").value();
  EXPECT_EQ(name.explained({Errc::invalid_argument, "topic 'left/raw' is odd"}).message,
            "topic 'left/raw' is odd (the program calls this topic '~/image')");
  EXPECT_EQ(left_cam().topic("/a")->explained({Errc::invalid_argument, "odd"}).message, "odd");
}

TEST(RemappingTest, WhatIsNoRuleIsNamedTogetherWithWhatARuleIs) {
  const std::vector<std::pair<const char*, const char*>> wrong{
      {"points=left", "it has no ':='"},
      {"-r", "it has no ':='"},
      {":=a", "the topic before ':=' is empty"},
      {"a:=", "what stands behind ':=' is empty"},
      {"a:=b:=c", "it has a second ':='"},
      {"a//b:=c", "the topic before ':=' has nothing between two slashes"},
      {"a:=b/", "what stands behind ':=' ends with a slash"},
      {"~a:=b", "the topic before ':=' has a '~' in it"},
      {"a:=~//b", "what stands behind ':=' has nothing between two slashes"},
      {":a:=b", "the name of the node is empty"},
      {"a-b:a:=b", "the name of the node has a character in it that is no letter"},
      {"a:=9lives", "what stands behind ':=' has a part that begins with a digit"},
      {"my-topic:=a", "the topic before ':=' has a character in it that is no letter"},
      {"__node:=9lives", "what stands behind ':=' begins with a digit"},
      {"__ns:=/a-b", "what stands behind ':=' has a character in it that is no letter"},
      {"__nss:=/left", "there is no '__nss'"},
      {"__ns:=/left/", "what stands behind ':=' ends with a slash"},
      {"__node:=/left/cam", "what stands behind ':=' has a slash in it, which only the namespace"},
      {"__ns:=", "what stands behind ':=' is empty"},
      {"__node:=", "what stands behind ':=' is empty"}};
  for (const auto& [rule, why] : wrong) {
    const auto of_environment = Remapping::of({.name = "cam"}, rule);
    ASSERT_FALSE(of_environment) << rule;
    EXPECT_EQ(of_environment.error().code, Errc::invalid_argument);
    EXPECT_EQ(of_environment.error().message.find(
                  std::string("'") + rule + "' in the environment variable SFT_REMAP is no remapping rule: "),
              0U)
        << of_environment.error().message;
    EXPECT_THAT(of_environment.error().message, HasSubstr(why));
    EXPECT_THAT(of_environment.error().message, HasSubstr("; a rule is FROM:=TO, NODE:FROM:=TO,"));
    const auto of_program = Remapping::of({.name = "cam", .remap = {rule}}, nullptr);
    ASSERT_FALSE(of_program);
    EXPECT_THAT(of_program.error().message, HasSubstr("in NodeOptions::remap is no remapping rule"));
  }
}

TEST(RemappingTest, ANamespaceIsATopicWithoutAName) {
  for (const char* name : {"left/", "a//b", "~", " left", "my left", "9lives"}) {
    const auto refused = Remapping::of({.name = "cam", .namespace_ = name}, nullptr);
    ASSERT_FALSE(refused) << name;
    EXPECT_THAT(refused.error().message, HasSubstr("NodeOptions::namespace_ '" + std::string(name) + "' "));
  }
  EXPECT_EQ(Remapping::of({.name = "cam", .namespace_ = "/"}, nullptr)->node(), "cam");
}

TEST(RemappingTest, WhatIsTooLongInFullIsRefusedWithBothNames) {
  const Remapping names = left_cam();
  const std::string name(242, 'x');
  EXPECT_THAT(names.topic(name).error().message, HasSubstr("here, has more than 246 characters"));
  EXPECT_TRUE(names.topic("/" + name));
  EXPECT_THAT(
      Remapping::of({.name = "cam", .namespace_ = "left", .remap = {name + ":=a"}}, nullptr).error().message,
      HasSubstr("has more than 246 characters"));
}

TEST(RemappingTest, ANodeHasANameAsRos2AllowsIt) {
  for (const auto& [name, why] : {std::pair("", "the node's name '' is empty"),
                                  std::pair("left/cam", "the node's name 'left/cam' has a slash in it"),
                                  std::pair("my cam", "the node's name 'my cam' has a character in it"),
                                  std::pair("9lives", "the node's name '9lives' begins with a digit")}) {
    const auto refused = Remapping::of({.name = name}, nullptr);
    ASSERT_FALSE(refused) << name;
    EXPECT_THAT(refused.error().message, HasSubstr(why));
  }
}

}  // namespace
}  // namespace sft::core
