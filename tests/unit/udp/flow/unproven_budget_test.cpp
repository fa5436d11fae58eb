// All made-up destinations on one host together are sent no more than a budget.
#include "udp_transport/flow/unproven_budget.h"

#include <gtest/gtest.h>

namespace sft::udp {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t all = UnprovenBudget::datagrams_max;
constexpr UnprovenBudget::Time start{1h};
const core::IpAddress host{0x0A090002U}, other_host{0x0A090003U};

TEST(UnprovenBudgetTest, ComesBackByOneDatagramAfterEachSecondSinceItWasTouched) {
  static_assert(all == 64 && UnprovenBudget::refill == 1s);
  UnprovenBudget budget;
  const auto begin = start + 900ms;
  budget.spend(all, begin);
  EXPECT_EQ(budget.left(begin + 999ms), 0U) << "the time before does not count";
  EXPECT_EQ(budget.left(begin + 1s), 1U);
  EXPECT_EQ(budget.left(begin + 1999ms), 1U);
  EXPECT_EQ(budget.left(begin + 2s), 2U);
}

TEST(UnprovenBudgetTest, IsNeverMoreThanWholeOrLessThanNothing) {
  UnprovenBudget budget;
  budget.spend(5, start);
  EXPECT_EQ(budget.left(start + 1h), all);
  budget.spend(5, start + 1h);
  budget.give_back(10);
  EXPECT_EQ(budget.left(start + 1h), all);
  budget.spend(all + 5, start + 1h);
  EXPECT_EQ(budget.left(start + 1h), 0U);
}

TEST(UnprovenBudgetTest, StaysAsItIsForAThreadWhoseClockIsAMomentBehind) {
  UnprovenBudget budget;
  budget.spend(5, start);
  EXPECT_EQ(budget.left(start - 10s), all - 5);
}

TEST(UnprovenBudgetTest, CountsNoMarksToAHostForTenSecondsAfterAReport) {
  static_assert(UnprovenBudget::answers_for == 10s);
  UnprovenBudget budget;
  budget.answered(start);
  budget.spend(all, start + 9999ms);
  EXPECT_TRUE(budget.takes_mark(start + 9999ms));
  EXPECT_FALSE(budget.takes_mark(start + 10s));
}

TEST(UnprovenBudgetTest, IsOneForAllWhoSendToAHost) {
  UnprovenBudgets budgets;
  const auto one = budgets.of(host, start);
  EXPECT_EQ(budgets.of(host, start), one);
  EXPECT_NE(budgets.of(other_host, start), one);
}

TEST(UnprovenBudgetTest, IsForgottenOnceNobodyUsesItAndAllOfItHasComeBack) {
  UnprovenBudgets budgets;
  budgets.of(host, start)->spend(5, start);
  EXPECT_EQ(budgets.of(host, start)->left(start), all - 5) << "who begins anew has no more";
  const std::weak_ptr<UnprovenBudget> watched = budgets.of(host, start);
  static_cast<void>(budgets.of(other_host, start + 4999ms));
  EXPECT_FALSE(watched.expired());
  static_cast<void>(budgets.of(other_host, start + 5s));
  EXPECT_TRUE(watched.expired());
}

}  // namespace
}  // namespace sft::udp
