// Headers that sft_generate(... NAMESPACE on::robot) makes. The same source has declarations as in ROS 2's
// headers of the same messages.
namespace std_msgs::msg {
template <class Allocator>
struct Header_ {};
using Header = Header_<int>;
}  // namespace std_msgs::msg

namespace sensor_msgs::msg {
template <class Allocator>
struct PointCloud2_ {};
using PointCloud2 = PointCloud2_<int>;
}  // namespace sensor_msgs::msg

namespace std_srvs::srv {
struct SetBool {};
}  // namespace std_srvs::srv

#include <gtest/gtest.h>

#include <on/robot/sensor_msgs/msg/PointCloud2.hpp>
#include <on/robot/std_srvs/srv/SetBool.hpp>
#include <on/robot/torture_msgs/msg/Literals.hpp>
#include <on/robot/torture_msgs/msg/Mixed.hpp>
#include <type_traits>

#include "sft/type_support.h"

namespace sft {
namespace {

using OfRos = sensor_msgs::msg::PointCloud2;
using on::robot::sensor_msgs::msg::PointCloud2;
using on::robot::std_srvs::srv::SetBool;
using on::robot::torture_msgs::msg::Mixed;

static_assert(!std::is_same_v<OfRos, PointCloud2>);
static_assert(std::is_same_v<decltype(PointCloud2::header), on::robot::std_msgs::msg::Header>);
static_assert(std::is_same_v<decltype(Mixed::header), on::robot::std_msgs::msg::Header>);

TEST(MessagesInANamespaceOfTheUser, HaveTheNamesOfRosOnTheWire) {
  EXPECT_EQ(type_support<PointCloud2>().name(), "sensor_msgs::msg::PointCloud2");
  EXPECT_EQ(type_support<on::robot::std_msgs::msg::Header>().name(), "std_msgs::msg::Header");
  EXPECT_EQ(type_support<SetBool::Request>().name(), "std_srvs::srv::SetBool_Request");
  EXPECT_EQ(type_support<Mixed>().name(), "torture_msgs::msg::Mixed");
}

}  // namespace
}  // namespace sft
