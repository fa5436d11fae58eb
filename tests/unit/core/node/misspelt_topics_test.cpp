// Tests which topics are considered misspelt, and when the log names them.
#include "core/node/misspelt_topics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <sensor_msgs/msg/PointCloud2.hpp>

namespace sft::core {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(SimilarTopicTest, FewLettersCaseOrANamespaceMayDiffer) {
  for (const auto& [a, b] : {std::pair{"pints", "points"},
                             {"Points", "points"},
                             {"points", "lidar/points"},
                             {"/robot/scan", "scan"},
                             {"cmd_vel", "cmdvel"},
                             {"image_raw", "image_rwa"}}) {
    EXPECT_TRUE(is_similar_topic(a, b)) << a;
    EXPECT_TRUE(is_similar_topic(b, a)) << a;
  }
}

TEST(SimilarTopicTest, OtherNamesAndNumbersOfARowAreMeant) {
  for (const auto& [a, b] : {std::pair{"points", "points"},
                             {"camera1", "camera2"},
                             {"robot1/scan", "robot12/scan"},
                             {"scan", "imu"},
                             {"left/image", "right/image"},
                             {"tf", "tf_static"},
                             {"points", "datapoints"},
                             {"odom", "od"}}) {
    EXPECT_FALSE(is_similar_topic(a, b)) << a;
  }
}

class MisspeltTopicsTest : public ::testing::Test {
 protected:
  MisspeltTopicsTest() {
    table.add_ours(endpoint(Role::reader, ours, "pints", our_node), type);
    topics.added(ours, now);
  }
  static Endpoint endpoint(Role role, EndpointId id, const std::string& topic, NodeId node = 77) {
    Endpoint e;
    e.id = id;
    e.role = role;
    e.topic = topic;
    e.type_name = "sensor_msgs::msg::PointCloud2";
    e.node = "lidar";
    e.node_id = node;
    return e;
  }
  std::vector<std::string> after(std::chrono::seconds time) {
    return topics.look(
        table, [this](const std::string& type_name) { return publishers[type_name]; }, now + time);
  }
  void publish(const std::string& topic) {
    publishers["sensor_msgs::msg::PointCloud2"].push_back({topic, "lidar"});
  }

  static constexpr EndpointId ours = 1;
  static constexpr NodeId our_node = 5;
  const TypeSupport type{detail::TypeTable<sensor_msgs::msg::PointCloud2>::type};
  const Time now{1h};
  EndpointTable table;
  std::map<std::string, std::vector<Discovery::KnownPublisher>> publishers;  ///< by the names of their types
  MisspeltTopics topics;
};

TEST_F(MisspeltTopicsTest, ASimilarTopicOfTheSameTypeIsNamedAfterAWhileAndAgainAfterTwiceThatTime) {
  publish("points");
  EXPECT_THAT(after(2s), IsEmpty()) << "its publisher may not be known yet";
  const std::string sentence =
      "topic 'pints': no publisher of it was seen; did you mean 'points', which node 'lidar' publishes with "
      "the "
      "same type?";
  EXPECT_THAT(after(3s), ElementsAre(sentence));
  EXPECT_THAT(after(8s), IsEmpty());
  EXPECT_THAT(after(9s), ElementsAre(sentence));
}

TEST_F(MisspeltTopicsTest, ATopicThatIsPublishedIsNotLookedAtAgain) {
  publish("points");
  table.enter(endpoint(Role::writer, 3, "pints"));
  EXPECT_THAT(after(3s), IsEmpty());
  table.erase(3);
  EXPECT_THAT(after(1000s), IsEmpty());
}

/// Nodes of DDS are not in the table.
TEST_F(MisspeltTopicsTest, ATopicThatANodeOfDdsPublishesIsNotLookedAtAgain) {
  publish("pints");
  publish("points");
  EXPECT_THAT(after(3s), IsEmpty());
  publishers.clear();
  publish("points");
  EXPECT_THAT(after(1000s), IsEmpty());
}

TEST_F(MisspeltTopicsTest, ATopicOfAnotherTypeOrOneThatTheNodeSubscribesToIsNotMeant) {
  publishers["nav_msgs::msg::Odometry"] = {{"points", "robot"}};
  EXPECT_THAT(after(3s), IsEmpty());
  publish("pint");
  table.add_ours(endpoint(Role::reader, 6, "pint", our_node), type);
  EXPECT_THAT(after(9s), IsEmpty());
}

TEST_F(MisspeltTopicsTest, ASubscriberThatWasClosedIsForgotten) {
  publish("points");
  table.erase(ours);
  EXPECT_THAT(after(3s), IsEmpty());
}

}  // namespace
}  // namespace sft::core
