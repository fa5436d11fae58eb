#include "udp_transport/reliable/repair_queue.h"

#include <gtest/gtest.h>

#include "tests/unit/udp/start.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;
using KeptSize = RepairQueue::Size;

TEST(RepairQueueTest, GivesTheOldestPartOfThatSizeFirst) {
  RepairQueue queue(0);
  queue.ask_for({5, {0, 1'000'000}});
  queue.ask_for({6, {0, 1000}});
  queue.ask_for({4, {0, 1000}});
  EXPECT_EQ(queue.next(KeptSize::small, test_start)->ordinal, 6U);
  EXPECT_EQ(queue.next(KeptSize::small, test_start)->ordinal, 4U);
  EXPECT_FALSE(queue.next(KeptSize::small, test_start));
  EXPECT_EQ(queue.next(KeptSize::large, test_start)->ordinal, 5U);
  EXPECT_TRUE(queue.empty());
  EXPECT_EQ(queue.sent(), 3U);
}

TEST(RepairQueueTest, SendsAPartOnceInARoundTripHoweverOftenItIsAskedFor) {
  RepairQueue queue(0);
  queue.ask_for({5, {0, 1000}});
  queue.ask_for({5, {500, 1500}});
  EXPECT_TRUE(queue.next(KeptSize::small, test_start));
  queue.ask_for({5, {0, 100}});
  EXPECT_TRUE(queue.empty()) << "the part is on its way";
  queue.forget_sent_before(test_start - 1ms);
  queue.ask_for({5, {0, 100}});
  EXPECT_TRUE(queue.empty());
  queue.forget_sent_before(test_start);
  queue.ask_for({5, {0, 100}});
  EXPECT_FALSE(queue.empty());
}

TEST(RepairQueueTest, RemembersAsManyPartsThatWereSentAsMayWait) {
  RepairQueue queue(0);
  for (std::uint64_t ordinal = 1; ordinal <= RepairQueue::repairs_max + 1; ++ordinal) {
    queue.ask_for({ordinal, {0, 1000}});
    EXPECT_TRUE(queue.next(KeptSize::small, test_start));
  }
  queue.ask_for({2, {0, 1000}});
  EXPECT_TRUE(queue.empty());
  queue.ask_for({1, {0, 1000}});
  EXPECT_FALSE(queue.empty()) << "it was forgotten for the last one";
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
  EXPECT_EQ(queue.next(KeptSize::small, test_start)->ordinal, 6U);
  EXPECT_TRUE(queue.empty());
}

TEST(RepairQueueTest, LetsNoMorePartsWaitThanItsMost) {
  RepairQueue queue(0);
  for (std::uint64_t i = 0; i < 2 * RepairQueue::repairs_max; ++i) queue.ask_for({i, {0, 1}});
  std::size_t sent = 0;
  while (queue.next(KeptSize::small, test_start)) ++sent;
  EXPECT_EQ(sent, RepairQueue::repairs_max);
}

TEST(RepairQueueTest, TellsWhenItsRateAllowsTheNextPart) {
  RepairQueue queue(1'000'000);
  for (std::uint64_t i = 0; i < 3; ++i) queue.ask_for({i, {0, 2'000'000}});
  EXPECT_TRUE(queue.next(KeptSize::large, test_start)) << "a burst";
  EXPECT_EQ(queue.next_ready(test_start), RepairQueue::Time::max());
  EXPECT_FALSE(queue.next(KeptSize::large, test_start));
  const auto ready = queue.next_ready(test_start);
  EXPECT_GT(ready, test_start);
  EXPECT_TRUE(queue.next(KeptSize::large, ready));
}

/// A request for the first datagram of a sample is a repair with an empty range of bytes.
TEST(RepairQueueTest, APartCostsItsRateADatagramHoweverFewBytesAreAskedFor) {
  constexpr std::size_t burst_bytes = std::size_t{1} << 20, enough = 10'000;
  RepairQueue queue(1);
  std::size_t sent = 0;
  for (std::uint64_t ordinal = 0; ordinal < enough; ++ordinal) {
    queue.ask_for({ordinal, {0, 0}});
    sent += queue.next(KeptSize::small, test_start) ? 1 : 0;
  }
  EXPECT_GT(sent, 0U);
  EXPECT_LE(sent, burst_bytes / datagram_bytes_min + 1);
}

}  // namespace
}  // namespace sft::udp
