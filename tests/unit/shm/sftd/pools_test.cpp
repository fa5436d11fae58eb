// The division of a budget of memory into pools of chunks.
#include "shm_transport/sftd/pools.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "shm_transport/host/prepared_chunks.h"
#include "shm_transport/sftd/pool_choice.h"

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

/// Returns the number of chunks for samples of that size. These chunks have the smallest sufficient size.
std::uint32_t chunks_for(const shm::PoolPlan& plan, std::size_t sample_bytes) {
  const auto pool = std::ranges::lower_bound(plan.pools, sample_bytes, {}, &shm::Pool::bytes);
  return pool == plan.pools.end() ? 0 : pool->count;
}

// Checks the numbers of the table in docs/operations.md under "When memory runs short".
TEST(Pools, OfAnOrdinaryRobotHoldThreeLidarsAndCamerasAndLargeClouds) {
  const auto plan = shm::plan_pools(shm::default_pool_bytes, shm::Memory::on_demand);
  // In addition to the waiting samples of each lidar, one chunk is being written, and readers hold two.
  constexpr std::uint32_t waiting = 5, lidars = 3, of_each = waiting + 3;
  EXPECT_GE(chunks_for(plan, 6'300'000), lidars * of_each);
  EXPECT_GE(chunks_for(plan, 24'900'000), 8U) << "an image of a 4K camera";
  EXPECT_GE(chunks_for(plan, 33'000'000), 8U);
  EXPECT_GE(chunks_for(plan, 64 * MiB), 2U);
}

TEST(Pools, TakeNoMoreMemoryAtOnceThanACommonBudget) {
  for (const std::size_t budget : {320 * MiB, 600 * MiB, 1024 * MiB}) {
    const auto plan = shm::plan_pools(budget, shm::Memory::on_demand);
    EXPECT_LE(plan.bytes() - plan.bytes_on_demand(), 320 * MiB) << budget;
    EXPECT_EQ(shm::plan_pools(budget).bytes_on_demand(), 0U) << budget;
    EXPECT_EQ(shm::plan_pools(budget).bytes(), plan.bytes()) << budget;
  }
}

TEST(Pools, HaveMemoryOnDemandOnlyInChunksOfWhichAWriterKnowsThat) {
  for (const shm::Pool& pool : shm::plan_pools(2048 * MiB, shm::Memory::on_demand).pools) {
    if (pool.on_demand > 0) {
      EXPECT_GE(pool.bytes, shm::PreparedChunks::on_demand_bytes);
    }
    EXPECT_LE(pool.on_demand, pool.count);
  }
}

TEST(Pools, TakeAShareOfWhatTheHostHas) {
  constexpr std::size_t plenty = 64'000 * MiB;
  EXPECT_EQ(shm::default_budget({plenty, plenty}), shm::default_pool_bytes);
  EXPECT_EQ(shm::default_budget({400 * MiB, plenty}), 200 * MiB) << "half of the free space in /dev/shm";
  EXPECT_EQ(shm::default_budget({plenty, 2000 * MiB}), 500 * MiB) << "a quarter of the RAM";
  EXPECT_EQ(shm::default_budget({0, 0}), shm::smallest_budget_bytes);
}

TEST(Pools, SayWhenLargeSamplesDoNotFit) {
  EXPECT_NE(shm::plan_pools(30 * MiB).remark.find("do not fit"), std::string::npos);
}

}  // namespace
}  // namespace sft::test
