// The protocol of reliable delivery with simulated I/O and time, for thousands of seeds.
#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/simulation/udp/world.h"
#include "tests/support/test_seed.h"

namespace sft::simulation {
namespace {

#ifdef SFT_SANITIZED
constexpr std::uint64_t seeds = 500, beset_seeds = 20, churning_seeds = 4;
#else
constexpr std::uint64_t seeds = 10'000, beset_seeds = 200, churning_seeds = 12;
#endif
constexpr int shards = 4;

class Simulation : public testing::TestWithParam<int> {};

INSTANTIATE_TEST_SUITE_P(Shards, Simulation, testing::Range(0, shards));

/// If SFT_TEST_SEED is set, only that seed is simulated.
TEST_P(Simulation, DeliversAllThatHistoryAllowsInOrderAndComesToRest) {
  const bool alone = std::getenv("SFT_TEST_SEED") != nullptr;
  const std::uint64_t count = alone ? 1 : test::test_rounds(seeds / shards);
  const std::uint64_t first =
      test::test_seed() + (alone ? 0 : count * static_cast<std::uint64_t>(GetParam()));
  for (std::uint64_t seed = first; seed < first + count; ++seed) {
    const std::string failure = World(seed).run();
    ASSERT_EQ(failure, "") << "to repeat: SFT_TEST_SEED=" << seed;
  }
}

/// Besides the usual faults of networks, bits flip and fields are forged, in both directions.
TEST_P(Simulation, DeliversAllASecondAfterTheLastForgedDatagram) {
  const bool alone = std::getenv("SFT_TEST_SEED") != nullptr;
  const std::uint64_t count = alone ? 1 : test::test_rounds(beset_seeds / shards);
  const std::uint64_t first =
      test::test_seed() + (alone ? 0 : count * static_cast<std::uint64_t>(GetParam()));
  for (std::uint64_t seed = first; seed < first + count; ++seed) {
    const std::string failure = World(seed, Plan::beset).run();
    ASSERT_EQ(failure, "") << "to repeat: SFT_TEST_SEED=" << seed;
  }
}

/// Each run has some thousand of these changes. The conditions need more gates than a publisher keeps.
TEST_P(Simulation, KeepsAllExactAndNothingForLongWhileReadersJoinLeaveAndChangeTheirConditions) {
  const bool alone = std::getenv("SFT_TEST_SEED") != nullptr;
  const std::uint64_t count = alone ? 1 : test::test_rounds(churning_seeds / shards);
  const std::uint64_t first =
      test::test_seed() + (alone ? 0 : count * static_cast<std::uint64_t>(GetParam()));
  std::size_t gated_by_group = 0;
  for (std::uint64_t seed = first; seed < first + count; ++seed) {
    World world(seed, Plan::churning);
    const std::string failure = world.run();
    ASSERT_EQ(failure, "") << "to repeat: SFT_TEST_SEED=" << seed;
    EXPECT_GT(world.changes(), 2500U) << "to repeat: SFT_TEST_SEED=" << seed;
    gated_by_group += world.gated_by_group();
  }
  EXPECT_GT(gated_by_group, 0U);
}

}  // namespace
}  // namespace sft::simulation
