// The division of a budget of memory into pools of chunks.
#include "shm_transport/sftd/pools.h"

#include <gtest/gtest.h>

#include <string>

namespace sft::test {
namespace {

constexpr std::size_t MiB = 1 << 20;

TEST(Pools, HoldSixteenMebibyteSamplesByDefault) {
  const auto plan = shm::plan_pools(320 * MiB);
  EXPECT_GE(plan.largest(), 16 * MiB + 4096);
  EXPECT_GE(plan.pools.back().count, 2U);
  EXPECT_TRUE(plan.remark.empty()) << plan.remark;
}

TEST(Pools, NeverExceedTheBudgetAndNeverWasteMuchOfIt) {
  for (std::size_t budget = 4 * MiB; budget < 2048 * MiB; budget += budget / 7) {
    const auto plan = shm::plan_pools(budget);
    EXPECT_LE(plan.bytes(), budget) << budget;
    EXPECT_GE(plan.bytes(), budget * 4 / 5) << budget;
  }
}

TEST(Pools, GrowWithTheBudget) {
  std::size_t largest = 0;
  for (std::size_t budget = 4 * MiB; budget < 1024 * MiB; budget += 4 * MiB) {
    const auto plan = shm::plan_pools(budget);
    EXPECT_GE(plan.largest(), largest) << budget;
    largest = plan.largest();
  }
}

TEST(Pools, AreInOrderOfSizeWithAtLeastTwoChunksEach) {
  for (const std::size_t budget : {4 * MiB, 30 * MiB, 100 * MiB, 320 * MiB}) {
    const auto plan = shm::plan_pools(budget);
    for (std::size_t i = 0; i < plan.pools.size(); ++i) {
      EXPECT_GE(plan.pools[i].count, 2U);
      EXPECT_EQ(plan.pools[i].bytes % 8, 0U);
      if (i > 0) {
        EXPECT_GT(plan.pools[i].bytes, plan.pools[i - 1].bytes);
      }
    }
  }
}

TEST(Pools, SayWhenLargeSamplesDoNotFit) {
  EXPECT_NE(shm::plan_pools(30 * MiB).remark.find("do not fit"), std::string::npos);
}

}  // namespace
}  // namespace sft::test
