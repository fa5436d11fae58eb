// Topics and their types are listed from a table of endpoints.
#include "core/node/topics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nav_msgs/msg/Odometry.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>

#include "core/control/described_type.h"
#include "sft/detail/type_shape.h"
#include "sft/type_support.h"

namespace sft::core {
namespace {

using namespace detail;

using nav_msgs::msg::Odometry;
using sensor_msgs::msg::PointCloud2;
using ::testing::HasSubstr;

class TopicsTest : public ::testing::Test {
 protected:
  Endpoint& add(Role role, const char* node, const char* topic, const StructType& type) {
    Endpoint e;
    e.role = role;
    e.node = node;
    e.topic = topic;
    e.type_name = type.name;
    e.type_hash = structure_hash(type);
    e.type_description = announced_description(type).value();
    entries.push_back({.endpoint = e});
    return entries.back().endpoint;
  }
  Result<DynamicType> type(std::string_view topic) const {
    std::vector<const TableEntry*> all;
    for (const TableEntry& entry : entries) all.push_back(&entry);
    return type_of(topic, all, 7);
  }
  std::string error(std::string_view topic) const {
    const auto found = type(topic);
    return found ? "" : found.error().message;
  }

  const StructType& cloud = TypeTable<PointCloud2>::type;
  const StructType& odometry = TypeTable<Odometry>::type;
  std::vector<TableEntry> entries;
};

TEST_F(TopicsTest, TheTypeOfATopicIsThatOfItsPublishersOrElseOfItsSubscribers) {
  add(Role::reader, "b", "points", odometry);
  EXPECT_EQ(type("points")->name(), odometry.name);
  add(Role::writer, "a", "points", cloud);
  EXPECT_EQ(type("points")->name(), cloud.name);
}

TEST_F(TopicsTest, AnUnknownTopicIsAnErrorThatNamesTheOthers) {
  EXPECT_EQ(type("points").error().code, Errc::unavailable);
  EXPECT_THAT(
      error("points"),
      HasSubstr("nobody publishes or subscribes to 'points' in domain 7; no other topics were seen there"));
  add(Role::writer, "a", "pointz", cloud);
  add(Role::writer, "a", "odom", odometry);
  EXPECT_THAT(error("points"), HasSubstr("topics that were seen: odom, pointz"));
  for (const char* name : {"1", "2", "3", "4", "5", "6", "7", "8", "9", "10"})
    add(Role::writer, "a", name, cloud);
  EXPECT_THAT(error("points"), HasSubstr(", and 2 more"));
}

TEST_F(TopicsTest, PublishersOfDifferentTypesAreAnErrorThatNamesBoth) {
  add(Role::writer, "a", "points", cloud);
  add(Role::writer, "b", "points", cloud);
  EXPECT_EQ(error("points"), "");
  std::vector<Member> members(cloud.members.begin(), cloud.members.end());
  members[1].name = "rows";
  add(Role::writer, "c", "points", StructType(cloud.name, members));
  EXPECT_EQ(type("points").error().code, Errc::type_mismatch);
  EXPECT_THAT(error("points"), HasSubstr("node 'a' has sensor_msgs::msg::PointCloud2, node 'c' has "));
  EXPECT_THAT(error("points"), HasSubstr("member 2 is 'height' here, 'rows' there"));
}

TEST_F(TopicsTest, APublisherThatDoesNotDescribeItsTypeLeavesItToOthers) {
  add(Role::writer, "a", "points", cloud).type_description.clear();
  EXPECT_EQ(type("points").error().code, Errc::unavailable);
  EXPECT_THAT(error("points"), HasSubstr("its description is not announced"));
  add(Role::writer, "b", "points", cloud);
  EXPECT_EQ(type("points")->name(), cloud.name);
}

TEST_F(TopicsTest, AreListedByNameWithTheirTypesWhoUsesThemAndTheirQos) {
  add(Role::writer, "a", "points", cloud).qos = {.reliability = reliable, .history_depth = 3};
  add(Role::writer, "d", "points", cloud);
  add(Role::reader, "b", "points", cloud).qos = {.durability = transient_local};
  add(Role::reader, "c", "points", odometry);
  add(Role::writer, "a", "odom", odometry).type_description.clear();
  const auto topics = topics_of(entries);
  ASSERT_EQ(topics.size(), 2U);
  EXPECT_EQ(topics[0].name, "odom");
  EXPECT_FALSE(topics[0].types.at(0).type);
  ASSERT_EQ(topics[1].types.size(), 2U);
  const TopicInfo::Type& points = topics[1].types[1];
  EXPECT_EQ(points.name, cloud.name);
  EXPECT_EQ(points.publishers, (std::vector<std::string>{"a", "d"}));
  EXPECT_EQ(points.offered, (std::vector<Qos>{{.reliability = reliable, .history_depth = 3}, {}}));
  EXPECT_EQ(points.requested, std::vector<Qos>{{.durability = transient_local}});
  EXPECT_EQ(points.subscribers, std::vector<std::string>{"b"});
  EXPECT_EQ(points.type.value().support().leaves(), 15U);
}

}  // namespace
}  // namespace sft::core
