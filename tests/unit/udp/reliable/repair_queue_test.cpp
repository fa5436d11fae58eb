#include "udp_transport/reliable/repair_queue.h"

#include <gtest/gtest.h>

namespace sft::udp {
namespace {

using namespace std::chrono_literals;
using Size = RepairQueue::Size;

constexpr RepairQueue::Time now{1h};

TEST(RepairQueueTest, GivesTheOldestPartOfThatSizeFirst) {
  RepairQueue queue(0);
  queue.ask_for({5, {0, 1'000'000}});
  queue.ask_for({6, {0, 1000}});
  queue.ask_for({4, {0, 1000}});
  EXPECT_EQ(queue.next(Size::small, now)->ordinal, 6U);
  EXPECT_EQ(queue.next(Size::small, now)->ordinal, 4U);
  EXPECT_FALSE(queue.next(Size::small, now));
  EXPECT_EQ(queue.next(Size::large, now)->ordinal, 5U);
  EXPECT_TRUE(queue.empty());
  EXPECT_EQ(queue.sent(), 3U);
}

TEST(RepairQueueTest, SendsAPartOnceInARoundTripHoweverOftenItIsAskedFor) {
  RepairQueue queue(0);
  queue.ask_for({5, {0, 1000}});
  queue.ask_for({5, {500, 1500}});
  EXPECT_TRUE(queue.next(Size::small, now));
  queue.ask_for({5, {0, 100}});
  EXPECT_TRUE(queue.empty()) << "the part is on its way";
  queue.forget_sent_before(now - 1ms);
  queue.ask_for({5, {0, 100}});
  EXPECT_TRUE(queue.empty());
  queue.forget_sent_before(now);
  queue.ask_for({5, {0, 100}});
  EXPECT_FALSE(queue.empty());
}

TEST(RepairQueueTest, IgnoresPartsThatAreNone) {
  RepairQueue queue(0);
  queue.ask_for({5, {10, 10}});
  queue.ask_for({5, {10, 5}});
  EXPECT_TRUE(queue.empty());
  queue.ask_for({5, {0, 0}});
  EXPECT_FALSE(queue.empty()) << "the first datagram of a sample";
}

TEST(RepairQueueTest, DropsPartsOfSamplesThatAreGone) {
  RepairQueue queue(0);
  queue.ask_for({5, {0, 1000}});
  queue.ask_for({6, {0, 1000}});
  queue.drop_before(6);
  EXPECT_EQ(queue.next(Size::small, now)->ordinal, 6U);
  EXPECT_TRUE(queue.empty());
}

TEST(RepairQueueTest, LetsNoMorePartsWaitThanItsMost) {
  RepairQueue queue(0);
  for (std::uint64_t i = 0; i < 2 * RepairQueue::repairs_max; ++i) queue.ask_for({i, {0, 1}});
  std::size_t sent = 0;
  while (queue.next(Size::small, now)) ++sent;
  EXPECT_EQ(sent, RepairQueue::repairs_max);
}

TEST(RepairQueueTest, TellsWhenItsRateAllowsTheNextPart) {
  RepairQueue queue(1'000'000);
  for (std::uint64_t i = 0; i < 3; ++i) queue.ask_for({i, {0, 2'000'000}});
  EXPECT_TRUE(queue.next(Size::large, now)) << "a burst";
  EXPECT_EQ(queue.next_ready(now), RepairQueue::Time::max());
  EXPECT_FALSE(queue.next(Size::large, now));
  const auto ready = queue.next_ready(now);
  EXPECT_GT(ready, now);
  EXPECT_TRUE(queue.next(Size::large, ready));
}

}  // namespace
}  // namespace sft::udp
