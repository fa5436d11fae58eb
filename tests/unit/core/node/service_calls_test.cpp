// The rules of services in simulated time: the steps of a client's call, and the choice of the calls that a
// server carries out.
#include "sft/detail/service_calls.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace sft::detail {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using ::testing::StartsWith;
using StepKind = ClientCall::Step::Kind;

class ClientCallTest : public ::testing::Test {
 protected:
  static SeenServer server(std::uint64_t id, const std::string& node) {
    return {.id = id, .node = node, .matched = true, .connected = true, .reason = "another host"};
  }
  /// Advances the time to `end`, and returns the ids of the servers to which the call is sent meanwhile.
  std::vector<std::uint64_t> sent_until(ServiceTime end) {
    std::vector<std::uint64_t> sent;
    for (;;) {
      const ClientCall::Step step = call.next(now, seen);
      if (step.kind == StepKind::fail) return reason = step.reason, sent;
      if (step.kind == StepKind::send) sent.push_back(step.server);
      if (step.kind != StepKind::wait) continue;
      EXPECT_GT(step.until, now) << "it would spin";
      if (step.until > end) return now = end, sent;
      now = step.until;
    }
  }

  const ServiceTime begin = ServiceTime() + 1h;
  ServiceTime now = begin;
  ClientCall call{"lights", begin, 2s};
  std::vector<SeenServer> seen;
  std::string reason;
};

TEST_F(ClientCallTest, IsSentAtOnceToTheOneServerThatIsThere) {
  seen = {server(7, "lamp")};
  EXPECT_EQ(sent_until(begin), std::vector<std::uint64_t>{7});
}

TEST_F(ClientCallTest, IsSentOnceEvenIfItsThreadRunsTooLate) {
  seen = {server(7, "lamp")};
  now = begin + 3s;
  EXPECT_EQ(sent_until(begin + 1h), std::vector<std::uint64_t>{7});
  EXPECT_EQ(reason, "service 'lights': the server on node 'lamp' did not answer within 2 s");
}

TEST_F(ClientCallTest, WaitsForAServerUpToItsTimeout) {
  EXPECT_TRUE(sent_until(begin + 1500ms).empty());
  seen = {server(7, "lamp")};
  EXPECT_EQ(sent_until(begin + 1550ms), std::vector<std::uint64_t>{7});
}

TEST_F(ClientCallTest, EndsWithTheReasonIfThereIsNoServer) {
  EXPECT_TRUE(sent_until(begin + 1h).empty());
  EXPECT_EQ(now, begin + 2s);
  EXPECT_EQ(reason, "service 'lights': no server was there within 2 s");
}

TEST_F(ClientCallTest, IsRepeatedAtGrowingIntervalsUntilItsTimeout) {
  seen = {server(7, "lamp")};
  EXPECT_EQ(sent_until(begin + 1h), std::vector<std::uint64_t>(5, 7)) << "at 0, 100, 300, 700 and 1500 ms";
  EXPECT_EQ(reason, "service 'lights': the server on node 'lamp' did not answer within 2 s");
}

TEST_F(ClientCallTest, IsOverWhenItsServerIsGoneAndGoesToNoOther) {
  seen = {server(7, "lamp")};
  EXPECT_EQ(sent_until(begin + 50ms).size(), 1U);
  seen = {server(8, "lamp")};
  EXPECT_TRUE(sent_until(begin + 1h).empty());
  EXPECT_THAT(reason, HasSubstr("its server, on node 'lamp', has gone"));
  EXPECT_LE(now, begin + 150ms) << "the client looks often enough";
}

TEST_F(ClientCallTest, IsOverWhenItsServerIsStillKnownButNotAlive) {
  seen = {server(7, "lamp")};
  sent_until(begin + 50ms);
  seen[0].matched = false;
  sent_until(begin + 1h);
  EXPECT_THAT(reason, HasSubstr("has gone"));
}

TEST_F(ClientCallTest, GoesOnIfASecondServerComesAfterItWasSent) {
  seen = {server(7, "lamp")};
  sent_until(begin + 50ms);
  seen.push_back(server(8, "spot"));
  EXPECT_EQ(sent_until(begin + 150ms), std::vector<std::uint64_t>{7});
}

TEST_F(ClientCallTest, IsNotSentWhileThereAreTwoServersAndNamesThem) {
  seen = {server(7, "lamp"), server(8, "spot")};
  EXPECT_TRUE(sent_until(begin + 1s).empty());
  seen.pop_back();
  EXPECT_EQ(sent_until(begin + 1050ms), std::vector<std::uint64_t>{7}) << "one of them has ended";
  ClientCall other("lights", begin, 0s);
  seen = {server(7, "lamp"), server(8, "spot")};
  EXPECT_THAT(
      other.next(begin, seen).reason,
      StartsWith("service 'lights': there is more than one server, on the nodes 'lamp', 'spot': end"));
}

TEST_F(ClientCallTest, SaysWhyTheServerThatIsThereCannotBeCalled) {
  seen = {server(7, "lamp")};
  seen[0].connected = false;
  seen[0].reason = "calls do not reach it yet";
  EXPECT_TRUE(sent_until(begin + 1h).empty());
  EXPECT_EQ(reason,
            "service 'lights': the server on node 'lamp' could not be called within 2 s: calls do not reach "
            "it yet");
}

TEST_F(ClientCallTest, AnOtherThatDoesNotMatchIsNoServer) {
  seen = {server(7, "lamp"), server(8, "stranger")};
  seen[1].matched = false;
  EXPECT_EQ(sent_until(begin), std::vector<std::uint64_t>{7});
}

TEST_F(ClientCallTest, TakesAnyTimeout) {
  EXPECT_EQ(ClientCall("x", begin, -1s).timeout_ms(), 0U);
  EXPECT_EQ(ClientCall("x", begin, 1500us).timeout_ms(), 2U);
  EXPECT_EQ(ClientCall("x", begin, std::chrono::nanoseconds::max()).timeout_ms(), 4'294'967'295U);
  EXPECT_EQ(ClientCall("x", begin, std::chrono::nanoseconds::max()).next(begin, seen).kind, StepKind::wait);
}

class SeenServersTest : public ::testing::Test {
 protected:
  SeenServersTest() {
    calls.readers = {{.id = 1, .node = "lamp", .served = true}};
    replies.writers = {{.id = 7, .node = "lamp", .matched = true, .connected = true}};
  }
  bool is_available() const { return only_server(seen_servers(calls, replies)) != nullptr; }

  PublisherStatus calls;
  SubscriberStatus replies;
};

TEST_F(SeenServersTest, AServerIsThereWhenCallsAndRepliesCanGo) {
  EXPECT_TRUE(is_available());
  calls.readers[0].served = false;
  EXPECT_FALSE(is_available());
  EXPECT_EQ(seen_servers(calls, replies)[0].reason, "calls do not reach it yet");
  calls.readers[0].served = true;
  replies.writers[0].connected = false;
  EXPECT_FALSE(is_available());
}

TEST_F(SeenServersTest, WhoOnlyListensToCallsIsNoServer) {
  calls.readers[0].node = "sft echo";
  EXPECT_FALSE(is_available());
}

TEST_F(SeenServersTest, AServerWhoseLeaseIsOverIsNotThere) {
  replies.writers[0].alive = false;
  EXPECT_FALSE(is_available());
}

class ServedCallsTest : public ::testing::Test {
 protected:
  using Calls = ServedCalls<std::string>;
  using Todo = Calls::Todo;

  Todo heard(std::uint64_t client, std::uint64_t number) { return calls.heard(client, number, now); }
  void answer(std::uint64_t client, const std::string& text) {
    calls.answered(client, std::make_unique<std::string>(text), now, now + 2s);
  }

  Calls calls;
  ServiceTime now = ServiceTime() + 1h;
};

TEST_F(ServedCallsTest, ARepeatedCallGetsTheSameAnswerAndIsNotRunAgain) {
  EXPECT_EQ(heard(1, 5), Todo::run);
  answer(1, "on");
  now += 100ms;
  EXPECT_EQ(heard(1, 5), Todo::repeat);
  EXPECT_EQ(*calls.answer(1), "on");
}

TEST_F(ServedCallsTest, ARepetitionThatWaitedWhileTheHandlerRanIsNotAnsweredAgain) {
  EXPECT_EQ(heard(1, 5), Todo::run);
  now += 10s;
  answer(1, "on");
  EXPECT_EQ(heard(1, 5), Todo::nothing);
  EXPECT_EQ(heard(1, 5), Todo::nothing);
  now += Calls::repeat_least;
  EXPECT_EQ(heard(1, 5), Todo::repeat) << "the answer was lost";
  EXPECT_EQ(heard(1, 5), Todo::nothing) << "it has just been sent";
}

TEST_F(ServedCallsTest, ALateRepetitionOfAnEarlierCallIsNotRun) {
  EXPECT_EQ(heard(1, 5), Todo::run);
  EXPECT_EQ(heard(1, 6), Todo::run);
  EXPECT_EQ(heard(1, 5), Todo::nothing);
}

TEST_F(ServedCallsTest, ClientsHaveNumbersOfTheirOwn) {
  EXPECT_EQ(heard(1, 5), Todo::run);
  EXPECT_EQ(heard(2, 5), Todo::run);
  answer(2, "for 2");
  EXPECT_EQ(calls.answer(1), nullptr);
}

TEST_F(ServedCallsTest, CallsWithoutAClientAreAlwaysRun) {
  EXPECT_EQ(heard(0, 0), Todo::run);
  answer(0, "on");
  EXPECT_EQ(heard(0, 0), Todo::run);
  EXPECT_EQ(calls.answer(0), nullptr) << "nobody asks for it again";
}

TEST_F(ServedCallsTest, AnAnswerIsKeptAsLongAsItsClientRepeatsTheCall) {
  heard(1, 5);
  answer(1, "8 MB");
  now += 2s - 1ms;
  EXPECT_EQ(heard(1, 5), Todo::repeat);
  now += 1ms;
  EXPECT_EQ(heard(2, 1), Todo::run);
  EXPECT_EQ(calls.answer(1), nullptr) << "its memory is free";
  EXPECT_EQ(heard(1, 5), Todo::nothing) << "and still it is not run twice";
}

TEST_F(ServedCallsTest, TheClientThatWasHeardLongestAgoIsForgottenWhenThereAreTooMany) {
  for (std::uint64_t client = 1; client <= Calls::clients_max + 1; ++client) {
    now += 1ms;
    EXPECT_EQ(heard(client, 1), Todo::run);
  }
  EXPECT_EQ(heard(2, 1), Todo::nothing) << "it is known";
  EXPECT_EQ(heard(Calls::clients_max + 1, 1), Todo::nothing);
  EXPECT_EQ(heard(1, 1), Todo::run) << "it was forgotten";
}

}  // namespace
}  // namespace sft::detail
