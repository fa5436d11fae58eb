// Nodes that follow the topic "/clock", over each transport.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sft/sft.h>
#include <mutex>
#include <optional>
#include <rosgraph_msgs/msg/Clock.hpp>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/other_threads.h"
#include "tests/system/fixture.h"

namespace sft::test {
namespace {

using ClockMessage = rosgraph_msgs::msg::Clock;
using NodeTime = std::chrono::sys_time<std::chrono::nanoseconds>;

class SimulatedTimeTest : public PubSubTest {
 protected:
  // On a busy machine a node may discover the publisher of the clock late.
  SimulatedTimeTest() { expected_warning = "use_sim_time: there is no publisher of the topic"; }

  static NodeOptions following(const std::string& name) {
    NodeOptions options = node_options(GetParam(), name);
    options.use_sim_time = true;
    return options;
  }
  /// Publishes the time again and again until the node has received it, because best-effort samples may be
  /// lost.
  static bool follows(const Node& node, Publisher<ClockMessage>& clock, std::chrono::nanoseconds time) {
    const ClockMessage message{.clock = duration_message<builtin_interfaces::msg::Time>(time)};
    return eventually([&] {
      clock.publish(message);
      return node.now() == NodeTime(time);
    });
  }

  Node simulator = open("simulator");
};

TEST_P(SimulatedTimeTest, WithoutTheOptionTheTimeIsThatOfTheSystem) {
  const NodeTime before = std::chrono::system_clock::now();
  const NodeTime now = simulator.now();
  EXPECT_LE(before, now);
  EXPECT_LE(now, std::chrono::system_clock::now());
}

TEST_P(SimulatedTimeTest, IsZeroAtFirstThenThatOfTheClockAndStandsWhenTheClockEnds) {
  const Node robot = Node::open(following("robot")).value();
  std::optional<Publisher<ClockMessage>> clock = simulator.publisher<ClockMessage>("clock").value();
  EXPECT_EQ(robot.now(), NodeTime());
  EXPECT_TRUE(follows(robot, *clock, 10s + 500ms));
  EXPECT_EQ(robot.now(), NodeTime(10s + 500ms)) << "it does not go on by itself";
  EXPECT_TRUE(follows(robot, *clock, 3s)) << "it may go back";
  const Node copy = robot;
  EXPECT_EQ(copy.now(), NodeTime(3s));
  clock.reset();
  EXPECT_TRUE(eventually([&] {
    const auto subscribers = robot.snapshot().subscribers;
    return subscribers.size() == 1 && subscribers[0].writers.empty();
  }));
  EXPECT_EQ(robot.now(), NodeTime(3s));
}

TEST_P(SimulatedTimeTest, TheClockHasAnAbsoluteNameThatRulesMayChange) {
  NodeOptions options = following("robot");
  options.namespace_ = "left";
  const Node left = Node::open(options).value();
  options.remap = {"/clock:=/sim/clock"};
  const Node other = Node::open(options).value();
  auto clock = simulator.publisher<ClockMessage>("clock").value();
  auto sim_clock = simulator.publisher<ClockMessage>("sim/clock").value();
  EXPECT_TRUE(follows(left, clock, 1s));
  EXPECT_TRUE(follows(other, sim_clock, 2s));
  EXPECT_EQ(left.now(), NodeTime(1s));
}

TEST_P(SimulatedTimeTest, AnyThreadMayAskForTheTime) {
  const Node robot = Node::open(following("robot")).value();
  auto clock = simulator.publisher<ClockMessage>("clock").value();
  ASSERT_TRUE(follows(robot, clock, 1s));
  std::vector<std::jthread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&robot] {
      NodeTime last = robot.now();
      for (int asked = 0; asked < 1000; ++asked) {
        const NodeTime now = robot.now();
        EXPECT_GE(now, last) << "the clock does not go back here";
        last = now;
      }
    });
  }
  for (int n = 0; n < 1000; ++n)
    clock.publish({.clock = duration_message<builtin_interfaces::msg::Time>(1s + n * 1ms)});
}

TEST_P(SimulatedTimeTest, NeedsNoThreadThatCallsBack) {
  const Node robot = Node::open(following("robot")).value();
  auto clock = simulator.publisher<ClockMessage>("clock").value();
  ASSERT_TRUE(follows(robot, clock, 1s));
  for (const std::string& name : names_of_threads()) EXPECT_FALSE(name.starts_with("sft-call")) << name;
}

TEST_P(SimulatedTimeTest, TheLogSaysThatNobodyPublishesTheClock) {
  std::mutex mutex;
  std::string lines;
  NodeOptions options = following("robot");
  options.log = [&](LogLevel, std::string_view line) {
    const std::scoped_lock lock(mutex);
    lines += std::string(line) + "\n";
  };
  const Node robot = Node::open(options).value();
  EXPECT_TRUE(eventually([&] {
    const std::scoped_lock lock(mutex);
    return lines.find(
               "use_sim_time: there is no publisher of the topic 'clock', so the time of the node, "
               "Node::now(), is 0 until a publisher comes") != std::string::npos;
  }));
  EXPECT_EQ(robot.now(), NodeTime());
}

INSTANTIATE_TEST_SUITE_P(Ways, SimulatedTimeTest, ::testing::Values(Way::shm, Way::udp), way_name);

}  // namespace
}  // namespace sft::test
