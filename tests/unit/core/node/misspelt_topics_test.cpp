// Which topics are taken for misspelt ones, and when the log is to name them.
#include "core/node/misspelt_topics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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
    e.announcer = 11;
    return e;
  }
  std::vector<std::string> after(std::chrono::seconds time) { return topics.look(table, now + time); }

  static constexpr EndpointId ours = 1;
  static constexpr NodeId our_node = 5;
  const TypeSupport type{detail::TypeTable<sensor_msgs::msg::PointCloud2>::type};
  const Time now{1h};
  EndpointTable table{{.entries = 10}};
  MisspeltTopics topics;
};

TEST_F(MisspeltTopicsTest, ASimilarTopicOfTheSameTypeIsNamedAfterAWhileAndAgainAfterTwiceThatTime) {
  table.enter(endpoint(Role::writer, 2, "points"));
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
  table.enter(endpoint(Role::writer, 2, "points"));
  table.enter(endpoint(Role::writer, 3, "pints"));
  EXPECT_THAT(after(3s), IsEmpty());
  table.erase(3);
  EXPECT_THAT(after(1000s), IsEmpty());
}

TEST_F(MisspeltTopicsTest, ATopicOfAnotherTypeOrOneThatTheNodeSubscribesToIsNotMeant) {
  Endpoint other_type = endpoint(Role::writer, 2, "points");
  other_type.type_name = "nav_msgs::msg::Odometry";
  table.enter(other_type);
  table.enter(endpoint(Role::reader, 3, "points"));
  EXPECT_THAT(after(3s), IsEmpty()) << "of another type, or a subscriber";
  table.enter(endpoint(Role::writer, 4, "pint"));
  table.add_ours(endpoint(Role::reader, 6, "pint", our_node), type);
  EXPECT_THAT(after(9s), IsEmpty());
}

TEST_F(MisspeltTopicsTest, ASubscriberThatWasClosedIsForgotten) {
  table.enter(endpoint(Role::writer, 2, "points"));
  table.erase(ours);
  EXPECT_THAT(after(3s), IsEmpty());
}

}  // namespace
}  // namespace sft::core
