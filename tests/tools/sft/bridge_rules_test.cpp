// The rules of `sft bridge` and its files: what is read reaches the rule or the node, and mistakes are named.
#include "tools/sft/bridge_rules.h"

#include <gmock/gmock.h>

#include <fstream>
#include <string>
#include <vector>

#include "tests/support/temporary_directory.h"

namespace sft::tool {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::vector<BridgeRule> ways_of(const std::string& text) { return parse_bridge_rule(text, {}).value(); }

TEST(BridgeRulesTest, AnArrowNamesTheSideFromWhichSamplesComeAndBothHaveTwoWays) {
  struct Way {
    std::size_t from;
    const char *topic, *selection, *target;
  };
  struct Rule {
    const char* text;
    std::vector<Way> ways;
  };
  const std::vector<Rule> rules{
      {"/points{width} -> /robot/points", {{0, "points", "width", "robot/points"}}},
      {"cmd_vel <- robot/cmd_vel@every 2", {{1, "robot/cmd_vel", " @ every 2th", "cmd_vel"}}},
      {"a <-> b", {{0, "a", "", "b"}, {1, "b", "", "a"}}},
      {"tf", {{0, "tf", "", "tf"}}},
  };
  for (const auto& [text, ways] : rules) {
    SCOPED_TRACE(text);
    const std::vector<BridgeRule> parsed = ways_of(text);
    ASSERT_EQ(parsed.size(), ways.size());
    for (std::size_t i = 0; i < ways.size(); ++i) {
      EXPECT_EQ(parsed[i].text, text);
      EXPECT_EQ(parsed[i].from, ways[i].from);
      EXPECT_EQ(parsed[i].to(), 1 - ways[i].from);
      EXPECT_EQ(parsed[i].topic, ways[i].topic);
      EXPECT_EQ(parsed[i].selection, ways[i].selection);
      EXPECT_EQ(parsed[i].target, ways[i].target);
    }
  }
}

TEST(BridgeRulesTest, APatternAppliesToNamesWithBothEndsAndGivesItsMiddleToTheTarget) {
  const BridgeRule rule = ways_of("cam/*/image -> robot/*/raw").at(0);
  EXPECT_TRUE(rule.is_pattern());
  EXPECT_EQ(rule.target_of("cam/left/image"), "robot/left/raw");
  EXPECT_EQ(rule.target_of("cam/a/b/image"), "robot/a/b/raw");
  EXPECT_EQ(rule.target_of("cam//image"), "robot//raw") << "the middle may be empty";
  EXPECT_EQ(rule.target_of("cam/image"), std::nullopt) << "the two ends would overlap";
  EXPECT_EQ(rule.target_of("cam/left/images"), std::nullopt);
  EXPECT_EQ(rule.target_of("webcam/left/image"), std::nullopt);
  const BridgeRule plain = ways_of("points -> robot/points").at(0);
  EXPECT_FALSE(plain.is_pattern());
  EXPECT_EQ(plain.target_of("points"), "robot/points");
  EXPECT_EQ(plain.target_of("points2"), std::nullopt);
}

TEST(BridgeRulesTest, OnlyTheSameTopicOfTheSameSideToTheSameTargetIsCarriedTwice) {
  const auto together = [](const std::string& one, const std::string& other) {
    std::vector<BridgeRule> rules = ways_of(one);
    const std::vector<BridgeRule> more = ways_of(other);
    rules.insert(rules.end(), more.begin(), more.end());
    return check_rules(rules);
  };
  EXPECT_TRUE(together("a -> b", "c <-> c"));
  EXPECT_TRUE(together("a -> b", "a -> c"));
  EXPECT_TRUE(together("a -> c", "b -> c"));
  EXPECT_TRUE(together("a -> a", "a <- a"));
  EXPECT_THAT(together("a -> b", "a -> b").error().message, HasSubstr("'a' to 'b' twice: remove one"));
  EXPECT_FALSE(together("a <-> b", "a <- b"));
}

class BridgeFileTest : public ::testing::Test {
 protected:
  Result<void> read(const std::string& content) {
    std::ofstream(path_) << content;
    plan_ = {};
    return read_bridge_file(path_, plan_);
  }

  test::TemporaryDirectory folder_;
  const std::string path_ = (folder_.path() / "bridge.toml").string();
  BridgePlan plan_;
};

TEST_F(BridgeFileTest, WhatItSaysReachesTheNodesAndTheRules) {
  const Result<void> done = read(R"([[side]]
name = "robot"
domain = 31
dds = "never"
interfaces = ["eth0", "wlan0"]
peers = ["10.0.0.7"]
cyclonedds = "file:///etc/cyclonedds.xml"
limit_mbit = 20
[[side]]
domain = 0
dds = "always"
limit_mbit = 0.5
[[rule]]
rule = "a <-> b"
defaults = ["x", "y"]
priority = -100
reliable = true
[[rule]]
rule = "c"
priority = 100
)");
  ASSERT_TRUE(done) << done.error().message;
  const auto& [robot, other] = plan_.sides;
  EXPECT_EQ(robot.name, "robot");
  EXPECT_EQ(robot.node.domain, 31U);
  EXPECT_EQ(robot.node.vanilla_dds, NodeOptions::VanillaDds::never);
  EXPECT_THAT(robot.node.discovery.interfaces, ElementsAre("eth0", "wlan0"));
  EXPECT_THAT(robot.node.discovery.peers, ElementsAre("10.0.0.7"));
  EXPECT_EQ(robot.node.cyclonedds_config, "file:///etc/cyclonedds.xml");
  EXPECT_EQ(robot.node.udp.max_bytes_per_s, 2'500'000U) << "20 Mbit/s";
  EXPECT_EQ(other.name, "");
  EXPECT_EQ(other.node.domain, 0U);
  EXPECT_EQ(other.node.vanilla_dds, NodeOptions::VanillaDds::always);
  EXPECT_THAT(other.node.discovery.interfaces, IsEmpty());
  EXPECT_THAT(other.node.discovery.peers, IsEmpty());
  EXPECT_EQ(other.node.udp.max_bytes_per_s, 62'500U);
  ASSERT_EQ(plan_.rules.size(), 3U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_THAT(plan_.rules[i].options.defaults, ElementsAre("x", "y"));
    EXPECT_EQ(plan_.rules[i].options.priority, -100);
    EXPECT_TRUE(plan_.rules[i].options.reliable);
  }
  EXPECT_THAT(plan_.rules[2].options.defaults, IsEmpty());
  EXPECT_EQ(plan_.rules[2].options.priority, 100);
  EXPECT_FALSE(plan_.rules[2].options.reliable);
}

TEST_F(BridgeFileTest, WhatItDoesNotSayIsLeftToTheNode) {
  const Result<void> done = read("[[side]]\n[[side]]\n[[rule]]\nrule = \"a\"\n");
  ASSERT_TRUE(done) << done.error().message;
  const NodeOptions usual;
  for (const BridgeSide& side : plan_.sides) {
    EXPECT_EQ(side.node.domain, usual.domain);
    EXPECT_EQ(side.node.vanilla_dds, usual.vanilla_dds);
    EXPECT_EQ(side.node.cyclonedds_config, usual.cyclonedds_config);
    EXPECT_EQ(side.node.udp.max_bytes_per_s, usual.udp.max_bytes_per_s);
  }
}

TEST_F(BridgeFileTest, TheFirstMistakeIsNamedWithItsLineItsKeyAndAnExample) {
  struct Wrong {
    const char* content;
    const char* says;
  };
  const std::vector<Wrong> in_second_line{
      {"domain = -1", ":2: 'domain' has no such value: write for example domain = 0"},
      {"domain = 233", "'domain'"},
      {"domain = \"5\"", "'domain'"},
      {"name = 5", R"(:2: 'name' has no such value: write for example name = "robot")"},
      {"dds = \"sometimes\"", R"(:2: 'dds' has no such value: write for example dds = "auto", or "always")"},
      {"peers = \"10.0.0.7\"", ":2: 'peers' has no such value"},
      {"interfaces = [\"eth0\", 5]", ":2: 'interfaces' has no such value"},
      {"limit_mbit = -0.1", ":2: 'limit_mbit' has no such value: write for example limit_mbit = 20.0"},
      {"limit_mbit = 1e6", ":2: 'limit_mbit'"},
      {"radio = true", ":2: 'radio' is no key here; there are name, domain, dds, interfaces"}};
  for (const Wrong& one : in_second_line) {
    const Result<void> done = read(std::string("[[side]]\n") + one.content + "\n[[side]]\nradio = true\n");
    ASSERT_FALSE(done) << one.content;
    EXPECT_THAT(done.error().message, ::testing::StartsWith(path_ + ":2: "));
    EXPECT_THAT(done.error().message, HasSubstr(one.says));
  }
  const std::string sides = "[[side]]\n[[side]]\n[[rule]]\n";
  const std::vector<Wrong> in_rules{{"priority = 101\nrule = \"a\"", ":4: 'priority' has no such value"},
                                    {"priority = -101\nrule = \"a\"", ":4: 'priority' has no such value"},
                                    {"reliable = \"yes\"\nrule = \"a\"", ":4: 'reliable' has no such value"},
                                    {"defaults = \"x\"\nrule = \"a\"", ":4: 'defaults' has no such value"},
                                    {"", ":3: 'rule' has no such value"},
                                    {"rule = \"a* -> b\"", ":3: rule 'a* -> b': both names have a *"}};
  for (const Wrong& one : in_rules) {
    const Result<void> done = read(sides + one.content + "\n");
    ASSERT_FALSE(done) << one.content;
    EXPECT_THAT(done.error().message, HasSubstr(one.says));
  }
  EXPECT_THAT(read("[[side]]\n").error().message, HasSubstr("write [[side]] twice"));
  EXPECT_THAT(read("[[side]]\n[[side]]\n[[side]]\n").error().message, HasSubstr("write [[side]] twice"));
  EXPECT_THAT(read("rule = \"a\"\n[[side]]\n[[side]]\n").error().message,
              HasSubstr(":1: 'rule' is no list: write [[rule]]"));
  EXPECT_THAT(read("speed = 1\n[[side]]\n[[side]]\n").error().message,
              HasSubstr(":1: 'speed' is no key here; there are [[side]] and [[rule]]"));
  EXPECT_THAT(read("[[side]]\nname = \n").error().message, HasSubstr("bridge.toml:2: "));
  EXPECT_THAT(read_bridge_file(path_ + ".other", plan_).error().message, HasSubstr("bridge.toml.other"));
}

}  // namespace
}  // namespace sft::tool
