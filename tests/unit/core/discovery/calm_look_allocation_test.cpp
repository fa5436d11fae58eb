// In calm, a look at discovery allocates nothing, however many others say that they live.
#include <gtest/gtest.h>

#include <deque>

#include "core/discovery/discovery_ear.h"
#include "core/discovery/life_signs.h"
#include "tests/support/thread_allocations.h"
#include "tests/unit/core/discovery/other_process.h"

namespace sft::core {
namespace {

using namespace test;

Time now_of_look{1000s};

class CalmLook : public ::testing::Test {
 protected:
  CalmLook() {
    ear.link_expected(lan_of_others, true);
    ear.hears(Role::writer, now_of_look);
    for (std::uint8_t number = 1; number <= 64; ++number) {
      OtherProcess& other = others.emplace_back(participants, number);
      ear.participant_speaks(other.speaker);
      ear.endpoint_came(other.speaker, other.writer);
      ear.assertion_came(other.speaker, other.full_sign(), full_sign_lease);
    }
  }

  /// The allocations of a look that finds that all have said once more what they said before.
  std::uint64_t allocations_of_look() {
    const Time since = now_of_look;
    now_of_look += life_signs_by_pulses.pause_in_calm;
    const std::uint64_t before = sft::test::thread_allocations();
    for (const OtherProcess& other : others)
      EXPECT_TRUE(ear.pulse_came(lan_of_others, other.pulse(), participants, since));
    ear.pulses_heard(now_of_look);
    (void)ear.look_for_deafness(20s, now_of_look);
    (void)ear.tick(now_of_look);
    ear.pass_on();
    return sft::test::thread_allocations() - before;
  }

  DiscoveryEar ear{life_signs_by_pulses, [] { return now_of_look; }};
  Participants participants;
  std::deque<OtherProcess> others;
};

TEST_F(CalmLook, AllocatesNothing) {
  for (int look = 0; look < 2; ++look)
    EXPECT_GT(allocations_of_look(), 0u) << "it is not known yet that all is steady";
  for (int look = 0; look < 5; ++look) EXPECT_EQ(allocations_of_look(), 0u);
}

TEST_F(CalmLook, AllocatesNothingForAFullSignThatSaysTheSame) {
  for (int look = 0; look < 4; ++look) (void)allocations_of_look();
  for (OtherProcess& other : others) ear.assertion_came(other.speaker, other.full_sign(), full_sign_lease);
  EXPECT_EQ(allocations_of_look(), 0u);
}

TEST_F(CalmLook, IsOverWithAnyEvent) {
  for (int look = 0; look < 4; ++look) (void)allocations_of_look();
  ear.participant_departed(others.front().speaker);
  others.pop_front();
  EXPECT_GT(allocations_of_look(), 0u);
}

}  // namespace
}  // namespace sft::core
