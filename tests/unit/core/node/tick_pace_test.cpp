#include "core/node/tick_pace.h"

#include <gtest/gtest.h>

namespace sft::core {
namespace {

using namespace std::chrono_literals;

constexpr Time begin{1h};

TEST(TickPaceTest, LooksAreSeldomWhereNothingHasHappened) {
  EXPECT_EQ(TickPace().next(begin), TickPace::pause_when_quiet);
}

TEST(TickPaceTest, LooksAreFrequentAfterSomethingHasHappenedAndBecomeRarer) {
  TickPace pace;
  pace.stirred(begin);
  EXPECT_EQ(pace.next(begin), TickPace::pause);
  EXPECT_EQ(pace.next(begin + 100ms), TickPace::pause);
  EXPECT_EQ(pace.next(begin + 240ms), 120ms);
  EXPECT_EQ(pace.next(begin + 400ms), 200ms);
  EXPECT_EQ(pace.next(begin + 1200ms), 600ms);
  EXPECT_EQ(pace.next(begin + 1h), TickPace::pause_when_quiet);
}

TEST(TickPaceTest, LooksAreFrequentAnewAfterEachEvent) {
  TickPace pace;
  pace.stirred(begin);
  pace.stirred(begin + 1s);
  EXPECT_EQ(pace.next(begin + 1s), TickPace::pause);
}

TEST(TickPaceTest, LooksAreFrequentWhileSamplesGoBySharedMemory) {
  TickPace pace;
  pace.note_traffic(0, begin);
  EXPECT_EQ(pace.next(begin), TickPace::pause_when_quiet);
  pace.note_traffic(1, begin);
  EXPECT_EQ(pace.next(begin), TickPace::pause);
  pace.note_traffic(1, begin + 1s);
  EXPECT_EQ(pace.next(begin + 2s), TickPace::pause_when_quiet);
}

}  // namespace
}  // namespace sft::core
