#include "udp_transport/flow/round_trips.h"

#include <gtest/gtest.h>

namespace sft::udp {
namespace {

using namespace std::chrono_literals;

constexpr RoundTrips::Time now{1h};

TEST(RoundTripsTest, KnowTheShortestTimeOfLate) {
  RoundTrips trips(10ms);
  EXPECT_EQ(trips.latest(), 10ms);
  EXPECT_EQ(trips.shortest(), RoundTrips::Duration::max());
  trips.note(2ms, now);
  trips.note(5ms, now);
  EXPECT_EQ(trips.latest(), 5ms);
  EXPECT_EQ(trips.shortest(), 2ms);
  EXPECT_EQ(trips.queueing(), 3ms);
}

TEST(RoundTripsTest, ForgetAShortestTimeThatIsTooOld) {
  RoundTrips trips(10ms);
  EXPECT_TRUE(trips.note(2ms, now));
  EXPECT_FALSE(trips.note(5ms, now + 10s));
  EXPECT_TRUE(trips.note(5ms, now + 10s + 1ms));
  EXPECT_EQ(trips.shortest(), 5ms);
}

TEST(RoundTripsTest, KnowNothingOfAnotherWay) {
  RoundTrips trips(10ms);
  trips.note(2ms, now);
  trips.forget();
  EXPECT_EQ(trips.latest(), 10ms);
  EXPECT_EQ(trips.shortest(), RoundTrips::Duration::max());
}

}  // namespace
}  // namespace sft::udp
