#include "core/names/names.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sft::core {
namespace {

using namespace std::string_literals;
using ::testing::HasSubstr;

TEST(NamesTest, WordsOfAllLanguagesAreNames) {
  for (const std::string& name :
       {"points"s, "/left/points"s, "größe"s, "点群"s, "🤖"s, "a b"s, std::string(255, 'n')}) {
    EXPECT_EQ(fault_of_name(name), "") << name;
    EXPECT_EQ(fault_of_announced_topic(name), "") << name;
  }
}

TEST(NamesTest, WhatAProgramNamesFollowsTheRulesOfRos2) {
  for (const std::string& topic : {"points"s, "/left/points"s, "_hidden"s, "a__b"s, "A9/b_9"s}) {
    EXPECT_EQ(fault_of_topic(topic), "") << topic;
    EXPECT_EQ(fault_of_namespace(topic), "") << topic;
  }
  EXPECT_EQ(fault_of_node("cam_2"), "");
  EXPECT_EQ(fault_of_namespace(""), "");
  EXPECT_EQ(fault_of_namespace("/"), "");
  for (const std::string& other : {"my topic"s, "a-b"s, "a.b"s, "größe"s, "a:b"s, "{a}"s}) {
    EXPECT_THAT(fault_of_topic(other), HasSubstr("ROS 2 allows no others in topics, services")) << other;
    EXPECT_THAT(fault_of_namespace(other), HasSubstr("ROS 2 allows no others in topics, services")) << other;
    EXPECT_THAT(fault_of_node(other), HasSubstr("ROS 2 allows no others in names of nodes")) << other;
  }
  for (const std::string& other : {"9lives"s, "/9lives"s, "cat/9lives"s}) {
    EXPECT_THAT(fault_of_topic(other), HasSubstr("begins with a digit, which ROS 2")) << other;
    EXPECT_THAT(fault_of_namespace(other), HasSubstr("begins with a digit, which ROS 2")) << other;
  }
  EXPECT_THAT(fault_of_node("9lives"), HasSubstr("begins with a digit, which ROS 2"));
  EXPECT_EQ(fault_of_node(""), "is empty");
  EXPECT_THAT(fault_of_node("left/cam"), HasSubstr("has a slash in it"));
}

TEST(NamesTest, NamesHaveAsManyCharactersAsRos2Allows) {
  EXPECT_EQ(fault_of_topic("/" + std::string(246, 'n')), "");
  EXPECT_THAT(fault_of_topic("/" + std::string(247, 'n')), HasSubstr("more than 246 characters"));
  EXPECT_EQ(fault_of_namespace(std::string(244, 'n')), "");
  EXPECT_THAT(fault_of_namespace(std::string(245, 'n')), HasSubstr("more than 244 characters"));
  EXPECT_EQ(fault_of_node(std::string(255, 'n')), "");
  EXPECT_THAT(fault_of_node(std::string(256, 'n')), HasSubstr("more than 255 bytes"));
}

TEST(NamesTest, ANameHasOneTo255Bytes) {
  EXPECT_EQ(fault_of_name(""), "is empty");
  EXPECT_EQ(fault_of_name(std::string(256, 'n')), "has more than 255 bytes");
}

TEST(NamesTest, ASlashBeforeATopicDoesNotCount) {
  EXPECT_EQ(fault_of_announced_topic("/" + std::string(255, 'n')), "");
  EXPECT_EQ(fault_of_announced_topic("/" + std::string(256, 'n')), "has more than 255 bytes");
}

TEST(NamesTest, ControlCharactersAreInNoName) {
  for (const std::string& name :
       {"a\0b"s, "a\nb"s, "a\x1b[2Jb"s, "a\x7f"s, "a\tb"s, "\xc2\x9b"s /* C1: CSI */,
        "\xe2\x80\xa8"s /* a line's end */, "\xe2\x80\xae"s /* backwards from here */})
    EXPECT_EQ(fault_of_name(name), "has a control character in it") << in_quotes(name);
}

TEST(NamesTest, WhatIsNoUtf8IsNoName) {
  for (const std::string& name :
       {"\xff"s, "a\x80"s, "\xc3"s, "\xc3("s, "\xc0\xaf"s /* too long for '/' */, "\xe0\x80\xaf"s,
        "\xed\xa0\x80"s /* a surrogate */, "\xf4\x90\x80\x80"s, "\xf5\x80\x80\x80"s})
    EXPECT_EQ(fault_of_name(name), "is not UTF-8") << in_quotes(name);
}

TEST(NamesTest, ATopicHasNoEmptyPartsNoBlanksAtItsEndsAndNoTilde) {
  for (const std::string& topic :
       {"//a"s, "a//b"s, "a/"s, "/"s, " a"s, "a "s, "/ a"s, "~/x"s, "~"s, ""s, "a\nb"s}) {
    EXPECT_NE(fault_of_announced_topic(topic), "") << in_quotes(topic);
    EXPECT_NE(fault_of_topic(topic), "") << in_quotes(topic);
  }
}

TEST(NamesTest, ASlashInFrontOfATopicIsTakenAway) {
  EXPECT_EQ(without_slash("points"), "points");
  EXPECT_EQ(without_slash("/points"), "points");
  EXPECT_EQ(without_slash("/left/points"), "left/points");
}

}  // namespace
}  // namespace sft::core
