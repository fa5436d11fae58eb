// Networks lose datagrams, and attackers forge records. Some time after the last loss or forgery, each
// process has the records of all others. If nothing is forged, no link is made anew.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <string>

#include "tests/simulation/control/control_world.h"
#include "tests/support/test_seed.h"

namespace sft::core::test {
namespace {

using sft::test::RandomTest;
using sft::test::test_rounds;

class ControlPlaneTest : public RandomTest {
 protected:
  struct Plan {
    int processes = 5;
    int networks = 1;
    int steps = 300;
    Time::duration pause = 300ms;  ///< the longest pause between two steps
    /// The probability of a change at each step; the following members are probabilities of other events.
    double changes = 0.8;
    double kills = 0;
    double attacks = 0;
    double claims = 0;
    double cuts = 0;
  };

  void live_through(ControlWorld& world, const Plan& plan) {
    for (int i = 0; i < plan.processes; ++i) world.start(plan.networks);
    for (int i = 0; i < plan.steps; ++i) {
      world.run(world.up_to(plan.pause));
      SimProcess& process = *world.processes()[world.below(world.processes().size())];
      if (process.is_killed) continue;
      if (world.chance(plan.changes)) world.change(process);
      if (world.chance(plan.attacks)) world.attack();
      if (world.chance(plan.claims)) world.claim(process, world.up_to(20s) + 1s);
      const int network = static_cast<int>(world.below(static_cast<std::size_t>(plan.networks)));
      if (world.chance(plan.cuts)) world.cut(network, !world.is_cut(network));
      if (world.chance(plan.kills)) {
        world.kill(process);
        world.start(plan.networks);
      }
    }
    for (int network = 0; network < plan.networks; ++network) world.cut(network, false);
  }

  /// Runs until the world has no error, but at most for that time. Returns the remaining error, or "".
  static std::string wrong_within(ControlWorld& world, Time::duration time) {
    for (const Time end = world.now() + time; world.now() < end && !world.what_is_wrong().empty();)
      world.run(100ms);
    return world.what_is_wrong();
  }

  int some_networks() { return 1 + static_cast<int>(random() % 3); }
};

/// A killed process is noticed within 7 s, and a new one is found sooner.
TEST_F(ControlPlaneTest, KnowsWhatAllHaveAndMakesNoLinkAnewWhereNothingIsForged) {
  for (std::uint64_t round = 0; round < test_rounds(20); ++round) {
    const std::uint64_t seed = random();
    SCOPED_TRACE("world " + std::to_string(seed));
    ControlWorld world(seed);
    live_through(world, {.networks = some_networks(), .kills = 0.02});
    EXPECT_EQ(wrong_within(world, 7s), "");
    EXPECT_EQ(world.renewals(), 0);
    EXPECT_EQ(world.steps_back(), 0);
  }
}

TEST_F(ControlPlaneTest, FollowsManyChangesASecond) {
  for (std::uint64_t round = 0; round < test_rounds(10); ++round) {
    const std::uint64_t seed = random();
    SCOPED_TRACE("world " + std::to_string(seed));
    ControlWorld world(seed);
    world.lose(round % 2 == 0 ? 0 : 0.2);
    live_through(world, {.networks = some_networks(), .steps = 3000, .pause = 20ms});
    EXPECT_EQ(wrong_within(world, 3s), "");
    EXPECT_EQ(world.renewals(), 0);
    // If datagrams are lost, records that arrive over a newly found link may be older than those that arrived
    // over another link.
    if (round % 2 == 0) {
      EXPECT_EQ(world.steps_back(), 0);
    }
  }
}

/// Sometimes all heartbeats within a lease are lost.
TEST_F(ControlPlaneTest, MakesNoLinkAnewWhereAFifthOfAllDatagramsGetsLost) {
  for (std::uint64_t round = 0; round < test_rounds(20); ++round) {
    const std::uint64_t seed = random();
    SCOPED_TRACE("world " + std::to_string(seed));
    ControlWorld world(seed);
    world.lose(0.2);
    live_through(world, {.networks = some_networks(), .kills = 0.02});
    EXPECT_EQ(wrong_within(world, 20s), "");
    EXPECT_EQ(world.renewals(), 0);
  }
}

TEST_F(ControlPlaneTest, FindsAllAgainAfterNetworksWereCut) {
  for (std::uint64_t round = 0; round < test_rounds(20); ++round) {
    const std::uint64_t seed = random();
    SCOPED_TRACE("world " + std::to_string(seed));
    ControlWorld world(seed);
    live_through(world, {.networks = some_networks(), .steps = 600, .kills = 0.01, .cuts = 0.02});
    EXPECT_EQ(wrong_within(world, 10s), "");
    EXPECT_EQ(world.renewals(), 0);
  }
}

TEST_F(ControlPlaneTest, OutlivesWhatIsForgedInTheNamesOfOthers) {
  for (std::uint64_t round = 0; round < test_rounds(40); ++round) {
    const std::uint64_t seed = random();
    SCOPED_TRACE("world " + std::to_string(seed));
    ControlWorld world(seed);
    world.lose(round % 2 == 0 ? 0 : 0.2);
    live_through(world,
                 {.networks = some_networks(), .kills = 0.02, .attacks = 0.03, .claims = 0.01, .cuts = 0.01});
    world.lose(0);
    EXPECT_EQ(wrong_within(world, 60s), "");
    world.run(90s);  // waits until wrong links beside a right one are made anew, too
    const int renewals = world.renewals();
    world.run(90s);
    EXPECT_EQ(world.renewals(), renewals);
    EXPECT_EQ(world.what_is_wrong(), "");
  }
}

TEST_F(ControlPlaneTest, HealsASingleForgeryByOneRenewalWithinFiveSeconds) {
  for (std::uint64_t round = 0; round < test_rounds(40); ++round) {
    const std::uint64_t seed = random();
    SCOPED_TRACE("world " + std::to_string(seed));
    ControlWorld world(seed);
    live_through(world, {.processes = 2, .steps = 60, .pause = 200ms});
    world.run(10s);
    world.attack();
    world.change(*world.processes()[0]);
    world.change(*world.processes()[1]);
    EXPECT_EQ(wrong_within(world, 5s), "");
    world.run(30s);
    EXPECT_LE(world.renewals(), 1);
  }
}

}  // namespace
}  // namespace sft::core::test
