// The guarantees of the negotiation, for every order of events. Every reader is served as long as it exists
// and no longer. It is served under exactly the newest selection that the writer's node has received, and by
// a path on which the reader is known to listen. When no more events happen, both sides agree. The world
// checks these guarantees after each step (negotiation_world.h). core/negotiation/negotiation.md names the
// test of each rule.
#include <gtest/gtest.h>

#include <sensor_msgs/msg/PointCloud2.hpp>

#include "tests/simulation/negotiation/negotiation_world.h"

#ifndef SFT_TEST_RUNS
#define SFT_TEST_RUNS 25000
#endif
#ifndef SFT_TEST_STEPS_LESS
#define SFT_TEST_STEPS_LESS 0
#endif

namespace sft::test {
namespace {

using namespace detail;

using core::Role;
using Plan = NegotiationWorld::Plan;
using Step = NegotiationWorld::Step;

const TypeSupport& points() {
  static const TypeSupport type{TypeTable<sensor_msgs::msg::PointCloud2>::type};
  return type;
}

/// Tries all orders of possible steps up to a depth, from the initial state and from the settled state. Every
/// order must end without a violation.
class AllOrders : public ::testing::Test {
 protected:
  void explore(const Plan& plan, int depth, int depth_when_settled) {
    const NegotiationWorld world(plan, points());
    explore(world, depth - SFT_TEST_STEPS_LESS);
    NegotiationWorld settled = world;
    settled.settle();
    explore(settled, depth_when_settled - SFT_TEST_STEPS_LESS);
    RecordProperty("orders", std::to_string(orders_));
    EXPECT_GT(orders_, 1000);
  }

 private:
  void explore(NegotiationWorld world, int depth) {
    if (HasFailure()) return;
    const std::vector<Step> steps = depth == 0 ? std::vector<Step>{} : world.steps();
    for (const Step& step : steps) {
      NegotiationWorld next = world;
      next.take(step);
      ASSERT_EQ(next.violation(), "") << next.history();
      explore(std::move(next), depth - 1);
    }
    if (!steps.empty()) return;
    ++orders_;
    world.settle();
    ASSERT_EQ(world.violation(), "") << world.history();
  }

  int orders_ = 0;
};

core::Qos durable(std::uint32_t history_depth = 3) {
  core::Qos qos;
  qos.durability = transient_local;
  qos.history_depth = history_depth;
  return qos;
}

Plan one_pair(const NegotiationWorld::Budget& budget) {
  return {.places = 2,
          .endpoints = {{.place = 0, .role = Role::writer}, {.place = 1, .role = Role::reader}},
          .budget = budget,
          .common_memory = false};
}

TEST_F(AllOrders, OfSelectionsThatChangeAndRequestsThatComeTwice) {
  explore(one_pair({.selection_changes = 2, .repetitions = 1}), 8, 10);
}

TEST_F(AllOrders, OfNodesThatLoseAndFindEachOther) {
  explore(one_pair({.selection_changes = 1, .losses = 1}), 8, 10);
}

TEST_F(AllOrders, OfNodesThatAreKilledAndComeBack) {
  explore(one_pair({.selection_changes = 1, .restarts = 1}), 7, 9);
}

TEST_F(AllOrders, OfEndpointsThatDepart) {
  explore(one_pair({.selection_changes = 1, .departures = 1, .repetitions = 1}), 7, 10);
}

TEST_F(AllOrders, OfMaximumRatesThatChange) {
  explore(one_pair({.selection_changes = 1, .rate_changes = 2}), 8, 10);
}

TEST_F(AllOrders, OfRetainedSamplesThatComeFirst) {
  Plan plan = one_pair({.losses = 1, .departures = 1});
  for (NegotiationWorld::EndpointPlan& endpoint : plan.endpoints) endpoint.qos = durable();
  plan.common_memory = true;
  explore(plan, 7, 9);
}

TEST_F(AllOrders, OfSharedMemoryThatComesAndGoes) { explore(one_pair({.memory_changes = 3}), 6, 8); }

class RandomOrders : public RandomTest {
 protected:
  int up_to(int most) { return std::uniform_int_distribution<int>(0, most)(random); }

  Plan random_plan() {
    Plan plan;
    plan.places = 2 + static_cast<std::size_t>(up_to(1));
    for (const Role role : {Role::writer, Role::reader}) {
      for (int i = up_to(2); i >= 0; --i) plan.endpoints.push_back(random_endpoint(plan.places, role));
    }
    plan.budget = {.selection_changes = up_to(8),
                   .rate_changes = up_to(4),
                   .losses = up_to(4),
                   .memory_changes = up_to(4),
                   .restarts = up_to(3),
                   .departures = up_to(2),
                   .repetitions = up_to(6),
                   .samples = 12};
    plan.common_memory = up_to(1) != 0;
    return plan;
  }

  NegotiationWorld::EndpointPlan random_endpoint(std::size_t places, Role role) {
    const int choice = up_to(5);  // 0: only shared memory, 1: only UDP, otherwise both
    return {.place = static_cast<std::size_t>(up_to(static_cast<int>(places) - 1)),
            .role = role,
            .may_use_memory = choice != 1,
            .may_use_network = choice != 0,
            .qos = random_qos(role)};
  }

  /// Returns random policies. Most pairs of them fit.
  core::Qos random_qos(Role role) {
    const bool more = up_to(3) == 0;  // whether a writer offers less, or a reader requests more, than most
    core::Qos qos = up_to(2) == 0 ? durable(1 + static_cast<std::uint32_t>(up_to(3))) : core::Qos{};
    qos.reliability = (role == Role::writer) != more ? reliable : best_effort;
    return qos;
  }
};

TEST_F(RandomOrders, EndWellAndNothingIsWrongOnTheWay) {
  for (std::uint64_t run = 0; run < test_rounds(SFT_TEST_RUNS); ++run) {
    NegotiationWorld world(random_plan(), points(), &random);
    for (int length = 30 + up_to(150); length > 0 && world.violation().empty(); --length) {
      const std::vector<Step>& steps = world.steps();
      if (steps.empty()) break;
      world.take(steps[random() % steps.size()]);
    }
    if (world.violation().empty()) world.settle();
    ASSERT_EQ(world.violation(), "") << "in run " << run << ", after\n" << world.history();
  }
}

}  // namespace
}  // namespace sft::test
