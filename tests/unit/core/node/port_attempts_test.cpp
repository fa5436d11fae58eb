// Ports that could not be opened are tried again, and the log says why they failed.
#include "core/node/port_attempts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/support/eventually.h"
#include "tests/unit/core/seam/idle_ports.h"

namespace sft::core {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

class PortAttemptsTest : public ::testing::Test {
 protected:
  PortAttempts::Open failing(Errc code, const std::string& why) {
    return [this, code, why] {
      ++calls;
      return Result<void>(fail(code, why));
    };
  }
  PortAttempts::Open working() {
    return [this] {
      ++calls;
      return Result<void>();
    };
  }
  static Time later() { return std::chrono::steady_clock::now() + Retry::pause_max; }

  int calls = 0;
  std::vector<std::string> logged;
  NodeLog log{"node", LogLevel::warning,
              [this](LogLevel, std::string_view text) { logged.emplace_back(text); }};
  PortAttempts attempts{log};
  Retry one, other;
};

TEST_F(PortAttemptsTest, WhatWorksIsNotPaused) {
  EXPECT_TRUE(attempts.over_network(one, working()));
  EXPECT_TRUE(attempts.over_network(one, working()));
  EXPECT_TRUE(attempts.in_memory(other, working()));
  EXPECT_EQ(calls, 3);
  EXPECT_THAT(logged, IsEmpty());
}

TEST_F(PortAttemptsTest, WhatHasFailedIsNotCalledAgainBeforeItsPauseIsOver) {
  EXPECT_FALSE(attempts.over_network(one, failing(Errc::system, "no socket")));
  EXPECT_FALSE(attempts.over_network(one, working()));
  EXPECT_EQ(calls, 1);
  EXPECT_THAT(logged, ElementsAre("node: no socket"));
  EXPECT_TRUE(one.due_again(later()));
}

TEST_F(PortAttemptsTest, ADaemonThatRefusesOneRequestIsAskedForOthersAtOnce) {
  attempts.in_memory(one, failing(Errc::limit_exceeded, "no port is left for 'points'"));
  attempts.in_memory(other, failing(Errc::limit_exceeded, "no port is left for 'imu'"));
  EXPECT_EQ(calls, 2);
  EXPECT_THAT(logged, ElementsAre("node: no port is left for 'points'", "node: no port is left for 'imu'"))
      << "each is a port of its own";
}

TEST_F(PortAttemptsTest, ADaemonThatDoesNotAnswerIsAskedNothingForAWhile) {
  attempts.in_memory(one, failing(Errc::unavailable, "no answer"));
  EXPECT_FALSE(attempts.in_memory(other, working()));
  EXPECT_EQ(calls, 1);
  EXPECT_THAT(logged, ElementsAre("node: no answer"));
  EXPECT_FALSE(attempts.may_retry_in_memory(one, std::chrono::steady_clock::now()));
  EXPECT_TRUE(attempts.may_retry_in_memory(one, later()));
}

TEST_F(PortAttemptsTest, WhatWasNotAskedMeanwhileMayBeTriedAgainAfterwards) {
  attempts.in_memory(one, failing(Errc::unavailable, "no answer"));
  attempts.in_memory(other, working());
  EXPECT_EQ(other.reason(), "no answer");
  EXPECT_FALSE(attempts.may_retry_in_memory(other, std::chrono::steady_clock::now()));
  EXPECT_TRUE(attempts.may_retry_in_memory(other, later()));
}

class SlowMemory : public IdleSharedMemory {
 public:
  bool awaits_answer() const override { return true; }
};

TEST_F(PortAttemptsTest, ADaemonThatWillAnswerSoonIsAskedAgainWithTheNextLookAndNoFailureIsLogged) {
  const SlowMemory memory;
  PortAttempts awaiting{log, &memory};
  EXPECT_FALSE(awaiting.in_memory(one, failing(Errc::unavailable, "not yet")));
  EXPECT_THAT(logged, IsEmpty());
  EXPECT_EQ(one.reason(), "not yet");
  EXPECT_TRUE(awaiting.may_retry_in_memory(one, std::chrono::steady_clock::now()));
  EXPECT_TRUE(awaiting.in_memory(other, working())) << "it may have answered that";
  EXPECT_TRUE(awaiting.in_memory(one, working()));
  EXPECT_FALSE(one.due_again(later()));
}

TEST_F(PortAttemptsTest, ADaemonThatHasAnsweredAgainIsLeftAloneForTheShortestPauseOnly) {
  attempts.in_memory(one, failing(Errc::unavailable, "no answer"));
  EXPECT_TRUE(test::eventually([&] {
    other = {};
    attempts.in_memory(other, failing(Errc::limit_exceeded, "no port is left"));
    return calls == 2;
  }));
  one = {};
  attempts.in_memory(one, failing(Errc::unavailable, "no answer"));
  EXPECT_EQ(calls, 3);
  EXPECT_TRUE(attempts.may_retry_in_memory(one, std::chrono::steady_clock::now() + Retry::pause_min));
}

TEST_F(PortAttemptsTest, AnotherDaemonIsAskedAtOnce) {
  attempts.in_memory(one, failing(Errc::unavailable, "no answer"));
  attempts.forget_daemon();
  EXPECT_TRUE(attempts.in_memory(other, working()));
}

}  // namespace
}  // namespace sft::core
