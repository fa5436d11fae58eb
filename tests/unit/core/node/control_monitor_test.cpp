// Tests of the log lines about endpoints that are refused because the table is full.
#include "core/node/control_monitor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace sft::core {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Tests with a negotiation whose table of endpoints can hold only one endpoint of another node.
class ControlMonitorTest : public ::testing::Test {
 protected:
  /// Announces `endpoints` endpoints on one topic, one after the other, so that few of them exist at the
  /// same time.
  void announce(const std::string& node, int endpoints) {
    for (int i = 0; i < endpoints; ++i) {
      Endpoint one;
      one.id = ++last_;
      one.role = Role::writer;
      one.topic = "points";
      one.node = node;
      one.announcer = 1;
      negotiation_.endpoint_seen(one);
    }
  }
  std::vector<std::string> lines_at(Time time) {
    lines_.clear();
    monitor_.log_refusals(time);
    return lines_;
  }

  const Time now{1h};

 private:
  EndpointId last_ = 0;
  std::vector<std::string> lines_;
  Negotiation negotiation_{{.endpoints = 1, .forget_lost_after = 60s}};
  NodeLog log_{"node", LogLevel::warning,
               [this](LogLevel, std::string_view text) { lines_.emplace_back(text); }};
  ControlMonitor monitor_{negotiation_, log_};
};

TEST_F(ControlMonitorTest, NamesWhoWasRefusedAtOnceAndThenOnceInAMinuteWithAllThatWereRefusedMeanwhile) {
  announce("one", 1 + 2);
  EXPECT_THAT(lines_at(now), ElementsAre(HasSubstr("refused: 2 of node 'one';")));
  announce("one", 3);
  EXPECT_THAT(lines_at(now + 1s), ElementsAre());
  announce("one", 4);
  announce("other", 1);
  EXPECT_THAT(lines_at(now + 59s), ElementsAre());
  EXPECT_THAT(lines_at(now + 60s), ElementsAre(HasSubstr("refused: 7 of node 'one', 1 of node 'other';")));
  EXPECT_THAT(lines_at(now + 3600s), ElementsAre()) << "nothing was refused since then";
}

TEST_F(ControlMonitorTest, NamesNoMoreThanTenNodesInALine) {
  for (int i = 10; i < 30; ++i) announce("node " + std::to_string(i), 2);
  const std::vector<std::string> lines = lines_at(now);
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_THAT(lines[0], HasSubstr("'node 19'"));
  EXPECT_THAT(lines[0], testing::Not(HasSubstr("'node 20'")));
}

}  // namespace
}  // namespace sft::core
