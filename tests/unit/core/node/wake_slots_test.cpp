// The slots of a node's page of doorbells. Each subscriber that waits has one of these slots.
#include "core/node/wake_slots.h"

#include <gtest/gtest.h>

#include <set>

namespace sft::core {
namespace {

TEST(WakeSlotsTest, EachIsTakenByOneAndAgainOnceItWasGivenBack) {
  WakeSlots slots;
  std::set<std::uint32_t> taken;
  while (const Result<std::uint32_t> slot = slots.take()) EXPECT_TRUE(taken.insert(*slot).second);
  EXPECT_FALSE(taken.contains(WakeSlots::dispatcher) || taken.contains(WakeSlots::poller));
  for (int round = 0; round < 3; ++round) {
    for (const std::uint32_t slot : taken) slots.give_back(slot);
    for (std::size_t i = 0; i < taken.size(); ++i) ASSERT_TRUE(slots.take()) << round;
    EXPECT_FALSE(slots.take());
  }
  slots.give_back(WakeSlots::dispatcher);
  EXPECT_FALSE(slots.take()) << "it is shared";
}

}  // namespace
}  // namespace sft::core
