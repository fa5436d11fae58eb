// These tests check the budget of datagrams to a host that has not answered. All destinations on the host
// share the budget, so that forged destinations cannot make SFT flood the host.
#include "udp_transport/flow/unproven_budget.h"

#include <gtest/gtest.h>

#include "tests/unit/udp/start.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t whole_budget = UnprovenBudget::datagrams_max;
const core::IpAddress one_host{0x0A090002U}, other_host{0x0A090003U};

TEST(UnprovenBudgetTest, ComesBackByOneDatagramAfterEachSecondSinceItWasTouched) {
  static_assert(whole_budget == 64 && UnprovenBudget::refill == 1s);
  UnprovenBudget budget;
  const auto begin = test_start + 900ms;
  budget.spend(whole_budget, begin);
  EXPECT_EQ(budget.left(begin + 999ms), 0U) << "the time before does not count";
  EXPECT_EQ(budget.left(begin + 1s), 1U);
  EXPECT_EQ(budget.left(begin + 1999ms), 1U);
  EXPECT_EQ(budget.left(begin + 2s), 2U);
}

TEST(UnprovenBudgetTest, IsNeverMoreThanWholeOrLessThanNothing) {
  UnprovenBudget budget;
  budget.spend(5, test_start);
  EXPECT_EQ(budget.left(test_start + 1h), whole_budget);
  budget.spend(5, test_start + 1h);
  budget.give_back(10);
  EXPECT_EQ(budget.left(test_start + 1h), whole_budget);
  budget.spend(whole_budget + 5, test_start + 1h);
  EXPECT_EQ(budget.left(test_start + 1h), 0U);
}

TEST(UnprovenBudgetTest, StaysAsItIsForAThreadWhoseClockIsAMomentBehind) {
  UnprovenBudget budget;
  budget.spend(5, test_start);
  EXPECT_EQ(budget.left(test_start - 10s), whole_budget - 5);
}

TEST(UnprovenBudgetTest, CountsNoMarksToAHostForTenSecondsAfterAReport) {
  static_assert(UnprovenBudget::answers_for == 10s);
  UnprovenBudget budget;
  budget.answered(test_start);
  budget.spend(whole_budget, test_start + 9999ms);
  EXPECT_TRUE(budget.takes_mark(test_start + 9999ms));
  EXPECT_FALSE(budget.takes_mark(test_start + 10s));
}

TEST(UnprovenBudgetTest, IsOneForAllWhoSendToAHost) {
  UnprovenBudgets budgets;
  const auto one = budgets.of(one_host, test_start);
  EXPECT_EQ(budgets.of(one_host, test_start), one);
  EXPECT_NE(budgets.of(other_host, test_start), one);
}

TEST(UnprovenBudgetTest, IsForgottenOnceNobodyUsesItAndAllOfItHasComeBack) {
  UnprovenBudgets budgets;
  budgets.of(one_host, test_start)->spend(5, test_start);
  EXPECT_EQ(budgets.of(one_host, test_start)->left(test_start), whole_budget - 5)
      << "who begins anew has no more";
  const std::weak_ptr<UnprovenBudget> watched = budgets.of(one_host, test_start);
  static_cast<void>(budgets.of(other_host, test_start + 4999ms));
  EXPECT_FALSE(watched.expired());
  static_cast<void>(budgets.of(other_host, test_start + 5s));
  EXPECT_TRUE(watched.expired());
}

}  // namespace
}  // namespace sft::udp
