// Tests of waiting for events that happen on other threads.
#include "core/sync/event_count.h"

#include <gtest/gtest.h>

#include <thread>

namespace sft::core {
namespace {

using namespace std::chrono_literals;

EventCount::TimePoint in(std::chrono::nanoseconds time) { return std::chrono::steady_clock::now() + time; }

TEST(EventCountTest, AnEventBetweenLookingAndWaitingIsNotMissed) {
  EventCount events;
  const std::uint64_t seen = events.value();
  events.raise();
  EXPECT_TRUE(events.wait_beyond(seen, in(0s)));
}

TEST(EventCountTest, WithoutAnEventTheDeadlineEndsTheWaiting) {
  EventCount events;
  events.raise();
  EXPECT_FALSE(events.wait_beyond(events.value(), in(1ms)));
}

TEST(EventCountTest, EventsOfAnotherThreadWake) {
  EventCount events;
  std::thread other([&] {
    for (int i = 0; i < 1000; ++i) events.raise();
  });
  for (std::uint64_t seen = 0; seen < 1000; seen = events.value())
    ASSERT_TRUE(events.wait_beyond(seen, in(10s)));
  other.join();
}

}  // namespace
}  // namespace sft::core
