#include "core/negotiation/accepted_requests.h"

#include <gtest/gtest.h>

#include <vector>

namespace sft::core {
namespace {

using namespace std::chrono_literals;
using Numbers = std::vector<std::uint64_t>;

class AcceptedRequestsTest : public testing::Test {
 protected:
  /// Returns a request that differs from the requests for all other numbers.
  static Wanted wanted(std::uint32_t number) { return {.selection = {}, .min_period_us = number}; }
  static Numbers periods(const AcceptedRequests& requests) {
    Numbers periods;
    for (const Accepted& accepted : requests.all()) periods.push_back(accepted.wanted.min_period_us);
    return periods;
  }
  static Numbers heard(const AcceptedRequests& requests) {
    Numbers numbers;
    for (const Accepted& accepted : requests.all()) {
      if (accepted.heard) numbers.push_back(accepted.request);
    }
    return numbers;
  }
  Time now{1h};
};

TEST_F(AcceptedRequestsTest, BestEffortForgetsAnEarlierOneAfterTwoSeconds) {
  AcceptedRequests requests(wanted(1), false);
  requests.asks_for(wanted(2), now);
  EXPECT_FALSE(requests.look(now + 2s));
  EXPECT_EQ(periods(requests), (Numbers{1, 2}));
  EXPECT_TRUE(requests.look(now + 2001ms));
  EXPECT_EQ(periods(requests), (Numbers{2}));
  EXPECT_FALSE(requests.look(now + 1h)) << "the latest stays";
}

TEST_F(AcceptedRequestsTest, BestEffortHasEachOnce) {
  AcceptedRequests requests(wanted(1), false);
  requests.asks_for(wanted(2), now);
  requests.asks_for(wanted(1), now);
  EXPECT_EQ(periods(requests), (Numbers{2, 1}));
}

TEST_F(AcceptedRequestsTest, NoTimeEndsThoseOfAReliableReader) {
  AcceptedRequests requests(wanted(1), true);
  requests.asks_for(wanted(2), now);
  requests.asks_for(wanted(1), now);
  requests.look(now + 24h);
  EXPECT_EQ(periods(requests), (Numbers{1, 2, 1}));
  EXPECT_EQ(requests.latest(), wanted(1));
}

TEST_F(AcceptedRequestsTest, AReliableReadersWritersHaveHeardOfARequestAfterTwoSeconds) {
  AcceptedRequests requests(wanted(1), true);
  requests.look(now);
  requests.asks_for(wanted(2), now);
  requests.asks_for(wanted(3), now + 1s);
  EXPECT_FALSE(requests.look(now + 2s));
  EXPECT_EQ(heard(requests), (Numbers{1}));
  EXPECT_TRUE(requests.look(now + 2001ms));
  EXPECT_EQ(heard(requests), (Numbers{1, 2}));
  EXPECT_TRUE(requests.look(now + 3001ms));
  EXPECT_EQ(heard(requests), (Numbers{1, 2, 3}));
  EXPECT_FALSE(requests.look(now + 3002ms));
}

TEST_F(AcceptedRequestsTest, ForgetsTheOldestOfTooMany) {
  for (const bool reliable : {false, true}) {
    AcceptedRequests requests(wanted(0), reliable);
    for (std::uint32_t i = 1; i <= 1000; ++i) requests.asks_for(wanted(i), now);
    const Numbers left = periods(requests);
    EXPECT_EQ(left.size(), reliable ? AcceptedRequests::reliable_max : AcceptedRequests::best_effort_max);
    EXPECT_EQ(left.front(), 1001 - left.size());
    EXPECT_EQ(left.back(), 1000U);
  }
}

}  // namespace
}  // namespace sft::core
