#include "core/platform/agent.h"

#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <vector>

#include "tests/support/eventually.h"

namespace sft::core {
namespace {

using namespace std::chrono_literals;

Agent::Duties no_duties() {
  return {.tick = [] { return 1000ms; }, .idle = [] { return 1000ms; }};
}

TEST(AgentTest, TasksRunInTheOrderInWhichTheyWerePostedEvenBeforeTheStart) {
  std::vector<int> order;
  Agent agent;
  agent.post([&] { order.push_back(1); });
  ASSERT_TRUE(agent.start("test", no_duties()));
  agent.post([&] { order.push_back(2); });
  agent.stop();
  EXPECT_EQ(order, (std::vector<int>{1, 2}));
}

TEST(AgentTest, StoppingRunsWhatRunningTasksPost) {
  bool ran = false;
  Agent agent;
  ASSERT_TRUE(agent.start("test", no_duties()));
  agent.post([&] { agent.post([&] { ran = true; }); });
  agent.stop();
  EXPECT_TRUE(ran);
}

TEST(AgentTest, IsBehindWhileTooManyTasksWait) {
  Agent agent;
  for (std::size_t i = 1; i < Agent::behind_from; ++i) agent.post([] {});
  EXPECT_FALSE(agent.is_behind());
  agent.post([] {});
  EXPECT_TRUE(agent.is_behind());
  EXPECT_FALSE(agent.is_behind(2 * Agent::behind_from + 2)) << "a batch is half as large as the node";
  ASSERT_TRUE(agent.start("test", no_duties()));
  agent.stop();
  EXPECT_FALSE(agent.is_behind());
}

TEST(AgentTest, IdleComesAfterABatchAndTicksKeepComing) {
  std::promise<void> idle;
  std::promise<void> third_tick;
  int ticks = 0;
  Agent agent;
  const Agent::Duties duties{.tick =
                                 [&] {
                                   if (++ticks == 3) third_tick.set_value();
                                   return 1ms;
                                 },
                             .idle =
                                 [&] {
                                   idle.set_value();
                                   return 1000ms;
                                 }};
  ASSERT_TRUE(agent.start("test", duties));
  agent.post([] {});
  EXPECT_EQ(idle.get_future().wait_for(test::hang_timeout), std::future_status::ready);
  EXPECT_EQ(third_tick.get_future().wait_for(test::hang_timeout), std::future_status::ready);
}

TEST(AgentTest, ABatchCanHastenTheNextTick) {
  std::promise<void> first_tick, second_tick;
  int ticks = 0;
  Agent agent;
  const Agent::Duties duties{.tick =
                                 [&] {
                                   ++ticks;
                                   if (ticks == 1) first_tick.set_value();
                                   if (ticks == 2) second_tick.set_value();
                                   return 1h;
                                 },
                             .idle = [] { return 1ms; }};
  ASSERT_TRUE(agent.start("test", duties));
  ASSERT_EQ(first_tick.get_future().wait_for(test::hang_timeout), std::future_status::ready);
  agent.post([] {});
  EXPECT_EQ(second_tick.get_future().wait_for(test::hang_timeout), std::future_status::ready);
}

TEST(AgentTest, ManyThreadsMayPost) {
  std::atomic<int> ran{0};
  Agent agent;
  ASSERT_TRUE(agent.start("test", no_duties()));
  std::vector<std::thread> posters;
  for (int t = 0; t < 4; ++t) {
    posters.emplace_back([&] {
      for (int i = 0; i < 1000; ++i) agent.post([&] { ++ran; });
    });
  }
  for (auto& t : posters) t.join();
  agent.stop();
  EXPECT_EQ(ran, 4000);
}

}  // namespace
}  // namespace sft::core
