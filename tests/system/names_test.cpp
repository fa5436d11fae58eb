// The names of topics of nodes with namespaces and remapping rules.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sft/sft.h>
#include <algorithm>
#include <cstdlib>
#include <mutex>
#include <optional>
#include <std_msgs/msg/Float64.hpp>
#include <std_srvs/srv/SetBool.hpp>
#include <string>
#include <vector>

#include "tests/system/fixture.h"

namespace sft::test {
namespace {

using std_msgs::msg::Float64;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class NamesTest : public ::testing::Test {
 protected:
  NodeOptions options(const std::string& name, const std::string& space = "",
                      const std::vector<std::string>& rules = {}) {
    NodeOptions options{.name = name, .namespace_ = space, .remap = rules, .transport = TransportChoice::udp};
    options.log = [this](LogLevel, std::string_view line) {
      const std::scoped_lock lock(mutex_);
      lines_.emplace_back(line);
    };
    return options;
  }
  Node open(const std::string& name, const std::string& space = "",
            const std::vector<std::string>& rules = {}) {
    return Node::open(options(name, space, rules)).value();
  }
  std::size_t lines_with(const std::string& text) {
    const std::scoped_lock lock(mutex_);
    return static_cast<std::size_t>(
        std::ranges::count_if(lines_, [&](const std::string& line) { return line.find(text) != line.npos; }));
  }
  static std::string error_of_open(const NodeOptions& options) {
    const Result<Node> node = Node::open(options);
    return node ? "" : node.error().message;
  }

 private:
  std::mutex mutex_;
  std::vector<std::string> lines_;
};

TEST_F(NamesTest, SamplesGoWhereTheNamesLead) {
  Node cam = open("cam", "/left", {"~/gain:=gain"});
  Node monitor = open("monitor");
  auto pub = cam.publisher<Float64>("~/gain").value();
  auto sub = monitor.subscriber<Float64>("left/gain").value();
  ASSERT_TRUE(pub.wait_for_subscribers(1, hang_timeout));
  pub.publish({.data = 7});
  ASSERT_TRUE(sub.wait(hang_timeout));
  const auto sample = sub.take();
  EXPECT_EQ(sample->data(), 7);
  EXPECT_EQ(sub.status().writers.at(0).node, "left/cam");
  EXPECT_EQ(cam.snapshot().name, "left/cam");
  EXPECT_EQ(cam.snapshot().publishers.at(0).topic, "left/gain");
  const DomainSnapshot domain = cam.domain();
  EXPECT_EQ(domain.publishers.at(0).given_topic, "~/gain");
  EXPECT_EQ(domain.subscribers.at(0).given_topic, "");
  EXPECT_TRUE(eventually([&] {
    return lines_with("the program's topic '~/gain' is 'left/gain', by the remapping rule '~/gain:=gain'") ==
           1;
  }));
}

TEST_F(NamesTest, EverythingThatTakesATopicFollowsTheRules) {
  Node cam = open("cam", "left", {"gain:=/shared/gain"});
  auto typed = cam.subscriber<Float64>("gain").value();
  const auto type = cam.find_type("gain", hang_timeout);
  ASSERT_TRUE(type) << type.error().message;
  auto pub = cam.publisher("gain", *type).value();
  auto sub = cam.subscriber("gain", *type, "*").value();
  EXPECT_TRUE(cam.ask_accounts("gain"));
  const std::vector<NodeSnapshot::Subscriber> subscribers = cam.snapshot().subscribers;
  EXPECT_EQ(subscribers.size(), 2U);
  for (const NodeSnapshot::Subscriber& subscriber : subscribers) EXPECT_EQ(subscriber.topic, "shared/gain");
  EXPECT_EQ(cam.snapshot().publishers.at(0).topic, "shared/gain");
  ASSERT_TRUE(eventually([&] { return cam.topics().size() == 1; }));
  const TopicInfo topic = cam.topics().at(0);
  EXPECT_EQ(topic.name, "shared/gain");
  EXPECT_THAT(topic.types.at(0).requested, ElementsAre(Qos{.history_depth = 8}, Qos{.history_depth = 8}));
}

TEST_F(NamesTest, AServiceIsRenamedByItsName) {
  using std_srvs::srv::SetBool;
  Node lamp = open("lamp", "left", {"~/lights:=lights"}), hand = open("hand", "", {"light:=left/lights"});
  const auto answer = [](const SetBool::Request& request) {
    return SetBool::Response{.success = request.data, .message = ""};
  };
  auto server = Service<SetBool>::open(lamp, "~/lights", answer).value();
  auto client = Client<SetBool>::open(hand, "light").value();
  const Result<SetBool::Response> response = client.call({.data = true}, hang_timeout);
  ASSERT_TRUE(response) << response.error().message;
  EXPECT_TRUE(response->success);
}

TEST_F(NamesTest, ErrorsAboutATopicHaveBothOfItsNames) {
  Node cam = open("cam", "left", {"gain:=volume"});
  const auto late = cam.publisher<Float64>("gain", {.transport = TransportChoice::shm});
  ASSERT_FALSE(late);
  EXPECT_THAT(late.error().message, HasSubstr("topic 'left/volume': "));
  EXPECT_THAT(late.error().message, HasSubstr(" (the program calls this topic 'gain')"));
  const auto unknown = cam.find_type("gain", 0s);
  ASSERT_FALSE(unknown);
  EXPECT_THAT(unknown.error().message, HasSubstr("'left/volume' in domain "));
  EXPECT_THAT(unknown.error().message, HasSubstr(" (the program calls this topic 'gain')"));
  EXPECT_FALSE(cam.subscriber<Float64>("~x"));
  EXPECT_FALSE(cam.find_type("~x", 0s));
  EXPECT_FALSE(cam.ask_accounts("~x"));
}

TEST_F(NamesTest, TheEnvironmentGoesBeforeTheProgram) {
  setenv("SFT_REMAP", "gain:=volume __ns:=/right", 1);
  const Node cam = open("cam", "left", {"gain:=loudness"});
  unsetenv("SFT_REMAP");
  Node same = cam;
  const auto pub = same.publisher<Float64>("gain").value();
  EXPECT_EQ(cam.snapshot().name, "right/cam");
  EXPECT_EQ(cam.snapshot().publishers.at(0).topic, "right/volume");
}

TEST_F(NamesTest, ABadRuleOrNamespaceIsAnErrorOfOpen) {
  EXPECT_THAT(error_of_open(options("cam", "left/")), HasSubstr("NodeOptions::namespace_ 'left/' ends"));
  EXPECT_THAT(
      error_of_open(options("cam", "", {"gain=volume"})),
      HasSubstr("'gain=volume' in NodeOptions::remap is no remapping rule: it has no ':='; a rule is"));
  setenv("SFT_REMAP", "gain:=volume __foo:=x", 1);
  EXPECT_THAT(error_of_open(options("cam")),
              HasSubstr("'__foo:=x' in the environment variable SFT_REMAP is no remapping rule"));
  unsetenv("SFT_REMAP");
}

TEST_F(NamesTest, WhatRos2RefusesIsRefusedWithTheRule) {
  using std_srvs::srv::SetBool;
  EXPECT_THAT(error_of_open(options("my cam")), HasSubstr("'my cam' has a character in it"));
  EXPECT_THAT(error_of_open(options("")), HasSubstr("the node's name '' is empty"));
  EXPECT_THAT(error_of_open(options("cam", "my left")), HasSubstr("'my left' has a character in it"));
  Node cam = open("cam");
  for (const char* const topic : {"my topic", "9lives"}) {
    EXPECT_THAT(cam.publisher<Float64>(topic).error().message, HasSubstr("ROS 2"));
    EXPECT_THAT(cam.subscriber<Float64>(topic).error().message, HasSubstr("ROS 2"));
    EXPECT_THAT(cam.find_type(topic, 0s).error().message, HasSubstr("ROS 2"));
    EXPECT_THAT(cam.ask_accounts(topic).error().message, HasSubstr("ROS 2"));
    EXPECT_THAT(Client<SetBool>::open(cam, topic).error().message, HasSubstr("ROS 2"));
  }
  EXPECT_THAT(Client<SetBool>::open(cam, "").error().message, HasSubstr("topic '' is empty"));
}

TEST_F(NamesTest, ARuleThatFitsNothingIsToldWhileTheNodesRun) {
  const std::vector<std::string> rules{"gain:=volume", "nosuch:=c", "lidar:gain:=c", "__ns:=/left"};
  Node cam = open("cam", "", rules), eye = open("eye", "", rules);
  const auto pub = eye.publisher<Float64>("gain").value();
  EXPECT_TRUE(eventually([&] { return lines_with("fits no topic and no node of this program") == 2; }));
  EXPECT_EQ(lines_with("'nosuch:=c' fits no topic"), 1U);
  EXPECT_EQ(lines_with("'lidar:gain:=c' fits no topic"), 1U);
}

TEST_F(NamesTest, ARuleThatFitsNothingIsToldWhenTheLastNodeCloses) {
  std::optional<Node> cam = open("cam", "", {"nosuch:=c"}), eye = open("eye", "", {"nosuch:=c"});
  cam.reset();
  eye.reset();
  EXPECT_EQ(lines_with("'nosuch:=c' fits no topic"), 1U);
}

TEST_F(NamesTest, TheStatusHasTheNumberOfTheDomain) {
  NodeOptions other = options("cam");
  other.domain = 17;
  EXPECT_EQ(Node::open(other).value().status().domain, 17U);
}

}  // namespace
}  // namespace sft::test
