#include "core/node/tick_pace.h"

#include <gtest/gtest.h>

namespace sft::core {
namespace {

using namespace std::chrono_literals;

constexpr Time begin{1h};

TEST(TickPaceTest, LooksAreSeldomWhereNothingHasHappened) {
  EXPECT_EQ(TickPace().next(begin), TickPace::pause_in_calm);
}

TEST(TickPaceTest, LooksAreFrequentForAWhileAfterSomethingHasHappened) {
  TickPace pace;
  pace.stirred(begin);
  EXPECT_EQ(pace.next(begin), TickPace::pause);
  EXPECT_EQ(pace.next(begin + TickPace::calm_after - 1ms), TickPace::pause);
  EXPECT_EQ(pace.next(begin + TickPace::calm_after), TickPace::pause_in_calm);
}

TEST(TickPaceTest, TheWhileBeginsAnewWithEachEvent) {
  TickPace pace;
  pace.stirred(begin);
  pace.stirred(begin + 1s);
  EXPECT_EQ(pace.next(begin + TickPace::calm_after + 500ms), TickPace::pause);
}

}  // namespace
}  // namespace sft::core
