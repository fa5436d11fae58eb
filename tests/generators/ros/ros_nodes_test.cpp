// Nodes that publish structs of ROS 2, and fill such structs from their samples, over shared memory and over
// UDP.
#include <gmock/gmock.h>

#include <sft/sft.h>
#include <my/sft_msgs/sensor_msgs/msg/PointCloud2.hpp>
#include <my/sft_msgs/test_interface_files/msg/Strings.hpp>
#include <optional>
#include <sensor_msgs/msg/point_cloud2.hpp>
#include <string>
#include <test_interface_files/msg/strings.hpp>
#include <vector>

#include "every_struct.h"
#include "tests/generators/ros/introspected.h"
#include "tests/support/eventually.h"

namespace sft::test {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

using PointCloud2 = ::my::sft_msgs::sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;
using RosCloud = ::sensor_msgs::msg::PointCloud2;

class RosNodesTest : public ::testing::TestWithParam<TransportChoice> {
 protected:
  static Node open(const std::string& name) {
    NodeOptions options{.name = name, .transport = GetParam()};
    options.shm.daemon_idle_exit = 5s;
    return Node::open(options).value();
  }
  template <class Subscriber>
  static auto next(Subscriber& subscriber) {
    EXPECT_TRUE(subscriber.wait(hang_timeout));
    return subscriber.take();
  }
  static RosCloud cloud(std::uint32_t height) {
    RosCloud cloud;
    cloud.header.frame_id = "lidar";
    cloud.height = height;
    cloud.fields.resize(2);
    cloud.fields[1].name = "y";
    cloud.data.resize(100'000, static_cast<std::uint8_t>(height));
    return cloud;
  }

  Node a = open("a");
  Node b = open("b");
  Publisher<PointCloud2> pub = a.publisher<PointCloud2>("points", {.reliability = reliable}).value();
};

TEST_P(RosNodesTest, AStructArrivesAsRosEncodesItAndFillsAnotherOne) {
  auto sub = b.subscriber<PointCloud2>("points").value();
  ASSERT_TRUE(pub.wait_for_subscribers(1, hang_timeout));
  const RosCloud sent = cloud(3);
  ASSERT_EQ(pub.publish(sent), PublishStatus::ok);
  const auto sample = next(sub);
  ASSERT_TRUE(sample);
  EXPECT_EQ(sample->height(), 3U);

  const auto* const ros = rosidl_typesupport_introspection_cpp::get_message_type_support_handle<RosCloud>();
  const std::vector<std::byte> body =
      serialized_by_ros(*static_cast<const RosMembers*>(ros->data), &sent, 1 << 18);
  const auto cdr = sample.cdr();
  EXPECT_EQ(std::vector(cdr.begin() + 4, cdr.end()), body);

  RosCloud got = cloud(7);
  ASSERT_TRUE(sample.fill(got));
  EXPECT_EQ(got, sent);
  PointCloud2 generated;
  ASSERT_TRUE(sample.fill(generated));
  EXPECT_EQ(generated.data, sent.data);
}

TEST_P(RosNodesTest, WhoeverListensAStructThatCannotBeSentIsRefusedWithTheNameOfTheField) {
  RosCloud bad = cloud(1);
  bad.header.frame_id = std::string("li\0dar", 6);
  const auto expect_refused = [&] {
    EXPECT_EQ(pub.publish(bad), PublishStatus::invalid);
    EXPECT_THAT(pub.why_invalid(), HasSubstr("'header.frame_id' has a NUL"));
  };
  expect_refused();
  auto sub = b.subscriber<PointCloud2, F::width>("points").value();
  ASSERT_TRUE(pub.wait_for_subscribers(1, hang_timeout));
  expect_refused();
}

TEST_P(RosNodesTest, ATextBeyondItsBoundIsRefused) {
  auto strings = a.publisher<::my::sft_msgs::test_interface_files::msg::Strings>("strings").value();
  ::test_interface_files::msg::Strings message;
  message.bounded_string_value = std::string(23, 'x');
  EXPECT_EQ(strings.publish(message), PublishStatus::invalid);
  EXPECT_THAT(strings.why_invalid(), HasSubstr("'bounded_string_value' has 23 characters; its bound is 22"));
}

TEST_P(RosNodesTest, ConditionsReadTheStruct) {
  SubscriberOptions options{.reliability = reliable, .depth = 100};
  options.selection = "@ height > 2 and changed(header.frame_id)";
  auto sub = b.subscriber<PointCloud2>("points", options).value();
  ASSERT_TRUE(pub.wait_for_subscribers(1, hang_timeout));
  for (const std::uint32_t height : {1, 4, 5, 2, 6}) {
    RosCloud sent = cloud(height);
    if (height == 6) sent.header.frame_id = "other";
    ASSERT_EQ(pub.publish(sent), PublishStatus::ok);
  }
  std::vector<std::uint32_t> heights;
  while (heights.empty() || heights.back() != 6) {
    const auto sample = next(sub);
    ASSERT_TRUE(sample);
    heights.push_back(sample->height());
  }
  EXPECT_THAT(heights, ElementsAre(4, 6));
}

TEST_P(RosNodesTest, FillAsksForAllFieldsIfTheSubscriberRecords) {
  SubscriberOptions options;
  options.recording = {.learn_samples = 3, .narrow_after_samples = 10, .as_remote = true};
  auto sub = b.subscriber<PointCloud2, recorded>("points", options).value();
  ASSERT_TRUE(pub.wait_for_subscribers(1, hang_timeout));
  const auto publish_and_take = [&] {
    pub.publish(cloud(3));
    return next(sub);
  };
  ASSERT_TRUE(eventually([&] {
    const auto sample = publish_and_take();
    (void)sample->height();
    return pub.status().readers.at(0).mask == FieldMask(F::height);
  }));

  RosCloud got;
  std::string why;
  ASSERT_TRUE(eventually([&] {
    const auto sample = publish_and_take();
    const Result<void> filled = sample.fill(got);
    if (!filled) why = filled.error().message;
    return filled.has_value();
  }));
  EXPECT_EQ(got, cloud(3));
  EXPECT_THAT(why, HasSubstr("lacks 'header.stamp.sec', which was not"));
}

TEST_P(RosNodesTest, WhatASampleLacksIsAnErrorOrStaysAsItWas) {
  SubscriberOptions options;
  options.selection = "height, header";
  auto sub = b.subscriber<PointCloud2, selected>("points", options).value();
  ASSERT_TRUE(pub.wait_for_subscribers(1, hang_timeout));
  pub.publish(cloud(3));
  const auto sample = next(sub);
  RosCloud got = cloud(7);
  got.width = 9;
  const Result<void> filled = sample.fill(got);
  if (GetParam() == TransportChoice::shm) {  // samples in shared memory have all fields
    ASSERT_TRUE(filled);
    EXPECT_EQ(got, cloud(3));
    return;
  }
  ASSERT_FALSE(filled);
  EXPECT_THAT(filled.error().message, HasSubstr("lacks 'width': select all fields"));

  const Result<FieldMask> fields = sample.fill_partial(got);
  ASSERT_TRUE(fields);
  EXPECT_EQ(*fields, FieldMask(F::height | F::header));
  EXPECT_EQ(got.height, 3U);
  EXPECT_EQ(got.width, 9U);
}

TEST_P(RosNodesTest, AnEmptySampleFillsNothing) {
  auto sub = b.subscriber<PointCloud2>("points").value();
  RosCloud got = cloud(7);
  EXPECT_FALSE(sub.take().fill(got));
  EXPECT_FALSE(sub.take().fill_partial(got));
  EXPECT_EQ(got, cloud(7));
}

INSTANTIATE_TEST_SUITE_P(, RosNodesTest, ::testing::Values(TransportChoice::shm, TransportChoice::udp),
                         [](const auto& param_info) {
                           return param_info.param == TransportChoice::shm ? "shm" : "udp";
                         });

}  // namespace
}  // namespace sft::test
