#include "udp_transport/flow/unproven_allowance.h"

#include <gtest/gtest.h>

#include <memory>

#include "tests/unit/udp/start.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;

constexpr FlowLimits unproven_limits{.unproven_bytes = 10'000, .unproven_datagrams = 4, .unproven_marks = 2};

TEST(UnprovenAllowanceTest, IsAFewDatagramsAndBytes) {
  UnprovenAllowance allowance(unproven_limits, nullptr);
  EXPECT_EQ(allowance.bytes_left(test_start), 4 * datagram_bytes_min);
  allowance.spend(1000, 3, test_start);
  EXPECT_EQ(allowance.bytes_left(test_start), datagram_bytes_min);
  EXPECT_EQ(allowance.datagrams_left(test_start), 1U);
  allowance.spend(9000, 0, test_start);
  EXPECT_EQ(allowance.bytes_left(test_start), 0U);
}

TEST(UnprovenAllowanceTest, IsNoMoreThanTheHostHasLeftAndGoesBackToTheHostOnceProven) {
  const auto host = std::make_shared<UnprovenBudget>();
  UnprovenAllowance allowance(unproven_limits, host);
  allowance.spend(100, 1, test_start);
  host->spend(UnprovenBudget::datagrams_max - 3, test_start);
  EXPECT_EQ(allowance.datagrams_left(test_start), 2U);
  allowance.proven();
  EXPECT_EQ(host->left(test_start), 3U);
}

TEST(UnprovenAllowanceTest, HasSomeMarksOfItsOwnAndThenThoseOfItsHost) {
  const auto host = std::make_shared<UnprovenBudget>();
  UnprovenAllowance allowance(unproven_limits, host);
  EXPECT_TRUE(allowance.takes_mark(test_start) && allowance.takes_mark(test_start));
  host->spend(UnprovenBudget::datagrams_max, test_start);
  EXPECT_FALSE(allowance.takes_mark(test_start));
  allowance.answered(test_start);
  EXPECT_TRUE(allowance.takes_mark(test_start)) << "a receiver on that host answers";
  allowance.begin_anew(nullptr);
  EXPECT_EQ(allowance.datagrams_left(test_start), 4U);
  const auto silent = std::make_shared<UnprovenBudget>();
  silent->spend(UnprovenBudget::datagrams_max, test_start);
  allowance.begin_anew(silent);
  EXPECT_TRUE(allowance.takes_mark(test_start) && allowance.takes_mark(test_start)) << "its own once more";
  EXPECT_FALSE(allowance.takes_mark(test_start));
}

}  // namespace
}  // namespace sft::udp
