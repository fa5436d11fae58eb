#include "udp_transport/flow/round_trips.h"

#include <gtest/gtest.h>

#include "tests/unit/udp/start.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;

TEST(RoundTripsTest, KnowTheShortestTimeOfLate) {
  RoundTrips trips(10ms);
  EXPECT_EQ(trips.latest(), 10ms);
  EXPECT_EQ(trips.shortest(), RoundTrips::Duration::max());
  trips.note(2ms, test_start);
  trips.note(5ms, test_start);
  EXPECT_EQ(trips.latest(), 5ms);
  EXPECT_EQ(trips.shortest(), 2ms);
  EXPECT_EQ(trips.queueing(), 3ms);
}

TEST(RoundTripsTest, ForgetAShortestTimeThatIsTooOld) {
  RoundTrips trips(10ms);
  EXPECT_TRUE(trips.note(2ms, test_start));
  EXPECT_FALSE(trips.note(5ms, test_start + 10s));
  EXPECT_TRUE(trips.note(5ms, test_start + 10s + 1ms));
  EXPECT_EQ(trips.shortest(), 5ms);
}

TEST(RoundTripsTest, KnowNothingOfAnotherWay) {
  RoundTrips trips(10ms);
  trips.note(2ms, test_start);
  trips.forget();
  EXPECT_EQ(trips.latest(), 10ms);
  EXPECT_EQ(trips.shortest(), RoundTrips::Duration::max());
}

}  // namespace
}  // namespace sft::udp
