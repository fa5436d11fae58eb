// Includes headers of the same messages with and without NAMESPACE in one source.
#include <gtest/gtest.h>

#include <on/robot/sensor_msgs/msg/PointCloud2.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>

#include "sft/type_support.h"

namespace sft {
namespace {

using Plain = sensor_msgs::msg::PointCloud2;
using Enclosed = on::robot::sensor_msgs::msg::PointCloud2;

TEST(MessagesInANamespaceOfTheUser, AreTheSameTypesToOtherPrograms) {
  EXPECT_EQ(type_support<Enclosed>().hash(), type_support<Plain>().hash());
  EXPECT_EQ(type_support<Enclosed>().name(), type_support<Plain>().name());
}

}  // namespace
}  // namespace sft
