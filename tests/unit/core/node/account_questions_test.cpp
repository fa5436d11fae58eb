// These tests check whom the program's questions go to, whose answers count, and how many of them there is
// room for.
#include "core/node/account_questions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/core/start.h"

namespace sft::core {
namespace {

using namespace std::chrono_literals;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr NodeId camera = 100, monitor = 200, liar = 300;

class AccountQuestionsTest : public ::testing::Test {
 protected:
  AccountQuestionsTest() {
    announce(Role::writer, 1, camera);
    announce(Role::reader, 2, monitor);
    questions.ask("points");
  }
  /// A participant has the number of its node, and one more.
  void announce(Role role, EndpointId id, NodeId node, const std::string& topic = "points") {
    Endpoint e;
    e.id = id;
    e.role = role;
    e.node_id = node;
    e.announcer = node + 1;
    e.topic = topic;
    endpoints[id] = e;
  }
  const Endpoint* known(EndpointId id) const {
    const auto found = endpoints.find(id);
    return found == endpoints.end() ? nullptr : &found->second;
  }
  static Account of_writer(PairId pair, std::uint64_t sent = 5) {
    return {.id = {pair, Role::writer}, .by_writer = {.sent = sent, .bytes_saved = 9}};
  }
  static Account of_reader(PairId pair) {
    return {.id = {pair, Role::reader}, .by_reader = {.received = 4, .lost = 1}};
  }
  void say(NodeId node, AnnouncerId participant, std::vector<Account> accounts) {
    const Assertion sign{
        .node = node, .writers = {}, .accounts = std::move(accounts), .announcer = participant};
    questions.answered(
        sign, [this](EndpointId id) { return known(id); }, now);
  }
  PairAccounts answers() { return questions.answers(now); }

  std::map<EndpointId, Endpoint> endpoints;
  AccountQuestions questions{{.answers = 100, .of_announcer = 30}};
  Time now = test_start;
};

TEST_F(AccountQuestionsTest, GoToAllWhoAreThereInTurns) {
  std::set<EndpointId> all;
  for (EndpointId id = 1; id <= 100; ++id) all.insert(id);
  std::set<EndpointId> asked;
  for (int i = 0; i < 2; ++i) {
    const std::vector<EndpointId> next = questions.take_turns(all);
    EXPECT_EQ(next.size(), asked_about_max);
    asked.insert(next.begin(), next.end());
  }
  EXPECT_EQ(asked, all);
}

TEST_F(AccountQuestionsTest, AreAnsweredByEachSideForItself) {
  say(camera, camera + 1, {of_writer({1, 2})});
  const DomainSnapshot::Account half = answers().at({1, 2});
  ASSERT_TRUE(half.publisher);
  EXPECT_EQ(half.publisher->sent, 5U);
  EXPECT_EQ(half.publisher->bytes_saved, 9U);
  EXPECT_FALSE(half.subscriber);
  now += 2s;
  say(monitor, monitor + 1, {of_reader({1, 2})});
  const DomainSnapshot::Account whole = answers().at({1, 2});
  EXPECT_EQ(whole.publisher->age, 2s);
  EXPECT_EQ(whole.subscriber->age, 0s);
  EXPECT_EQ(whole.subscriber->received, 4U);
  EXPECT_EQ(whole.subscriber->lost, 1U);
}

TEST_F(AccountQuestionsTest, AreNotAnsweredByOthersThanTheOneWhoAnnouncedTheEndpoint) {
  say(liar, liar + 1, {of_writer({1, 2}), of_reader({1, 2})});
  say(camera, liar + 1, {of_writer({1, 2})});
  say(monitor, monitor + 1, {of_writer({1, 2})});
  say(camera, camera + 1, {of_reader({1, 2})});
  EXPECT_THAT(answers(), IsEmpty());
}

TEST_F(AccountQuestionsTest, AreNotAnsweredByAccountsOfWhatIsNoPairOnATopicThatIsAskedAbout) {
  announce(Role::writer, 3, camera, "clouds");
  announce(Role::reader, 4, monitor, "clouds");
  announce(Role::writer, 5, camera);
  for (const PairId& pair :
       {PairId{3, 4}, PairId{1, 4}, PairId{3, 2}, PairId{1, 5}, PairId{1, 99}, PairId{0, 0}})
    say(camera, camera + 1, {of_writer(pair)});
  say(monitor, monitor + 1, {of_reader({2, 2})});
  EXPECT_THAT(answers(), IsEmpty());
}

TEST_F(AccountQuestionsTest, AreForgottenWithTheirAnswersOnceTheProgramHasTakenAllOfThemBack) {
  questions.ask("points");
  say(camera, camera + 1, {of_writer({1, 2})});
  questions.ask_no_more("points");
  EXPECT_TRUE(questions.asks_about("points"));
  EXPECT_THAT(answers(), SizeIs(1));
  questions.ask_no_more("points");
  EXPECT_FALSE(questions.asks());
  EXPECT_THAT(answers(), IsEmpty());
  questions.ask_no_more("points");
  EXPECT_FALSE(questions.asks()) << "once too often";
}

TEST_F(AccountQuestionsTest, HaveAnswersThatLastTenSecondsUnlessTheyAreRenewed) {
  say(camera, camera + 1, {of_writer({1, 2}, 5)});
  now += 6s;
  say(camera, camera + 1, {of_writer({1, 2}, 6)});
  now += 10s - 1ms;
  EXPECT_EQ(answers().at({1, 2}).publisher->sent, 6U);
  now += 1ms;
  EXPECT_THAT(answers(), IsEmpty());
}

// The table has room for a hundred. The liar announces what it likes, and answers for all of it.
TEST_F(AccountQuestionsTest, AreAnsweredByHonestNodesHoweverManyAnswersSomebodyMakesUp) {
  for (EndpointId id = 1000; id < 1200; ++id) announce(Role::writer, id, liar);
  std::vector<Account> many;
  for (EndpointId id = 1000; id < 1200; ++id) many.push_back(of_writer({id, 2}));
  say(liar, liar + 1, many);
  EXPECT_THAT(answers(), SizeIs(100));
  say(camera, camera + 1, {of_writer({1, 2})});
  say(monitor, monitor + 1, {of_reader({1, 2})});
  say(liar, liar + 1, many);
  const PairAccounts told = answers();
  EXPECT_THAT(told, SizeIs(99)) << "a pair has two of the hundred";
  EXPECT_TRUE(told.at({1, 2}).publisher);
  EXPECT_TRUE(told.at({1, 2}).subscriber);
}

TEST_F(AccountQuestionsTest, CountTheAnswerOfWhoeverAnnouncesTheEndpointByNow) {
  say(camera, camera + 1, {of_writer({1, 2}, 5)});
  endpoints[1].announcer = 77;  // the node's participant on another network
  say(camera, camera + 1, {of_writer({1, 2}, 6)});
  EXPECT_EQ(answers().at({1, 2}).publisher->sent, 5U);
  say(camera, 77, {of_writer({1, 2}, 7)});
  EXPECT_EQ(answers().at({1, 2}).publisher->sent, 7U);
}

}  // namespace
}  // namespace sft::core
