// Topics and types of SFT have the names in DDS that nodes of ROS 2 would give them.
#include "core/vanilla/dds_names.h"

#include <gtest/gtest.h>

namespace sft::core {
namespace {

using enum DdsNames;

TEST(DdsNames, OfTopicsBeginWithRtAsInRos) {
  EXPECT_EQ(dds_topic("points", ros2), "rt/points");
  EXPECT_EQ(dds_topic("/left/points", ros2), "rt/left/points");
}

TEST(DdsNames, OfTypesHaveTheNamespaceOfRosBeforeTheLastPart) {
  EXPECT_EQ(dds_type("sensor_msgs::msg::Imu", ros2), "sensor_msgs::msg::dds_::Imu_");
  EXPECT_EQ(dds_type("Imu", ros2), "dds_::Imu_");
}

TEST(DdsNames, OfTopicsAndTypesAreReadAsTheyAreMade) {
  EXPECT_EQ(topic_of_dds(dds_topic("left/points", ros2), ros2), "left/points");
  EXPECT_EQ(type_of_dds(dds_type("sensor_msgs::msg::Imu", ros2), ros2), "sensor_msgs::msg::Imu");
}

TEST(DdsNames, OfAnotherFormAreNotThoseOfRos) {
  for (const char* topic : {"points", "rt/", "rq/addRequest", "ros_discovery_info", ""})
    EXPECT_FALSE(topic_of_dds(topic, ros2)) << topic;
  for (const char* type : {"Square", "pkg::msg::dds_::Imu", ""}) EXPECT_EQ(type_of_dds(type, ros2), type);
}

TEST(DdsNames, OfTypesInRosHaveSlashes) {
  EXPECT_EQ(ros_type_name("sensor_msgs::msg::Imu"), "sensor_msgs/msg/Imu");
  EXPECT_EQ(ros_type_name("Imu"), "Imu");
}

TEST(DdsNames, AreThoseOfSftIfTheyArePlain) {
  EXPECT_EQ(dds_topic("/left/points", plain), "left/points");
  EXPECT_EQ(dds_type("sensor_msgs::msg::Imu", plain), "sensor_msgs::msg::Imu");
  EXPECT_EQ(topic_of_dds("left/points", plain), "left/points");
  EXPECT_EQ(type_of_dds("house::Door", plain), "house::Door");
}

TEST(DdsNames, OfTheGraphOfRosAreNoneOfSft) {
  for (const DdsNames names : {ros2, plain}) EXPECT_FALSE(topic_of_dds("ros_discovery_info", names));
}

}  // namespace
}  // namespace sft::core
