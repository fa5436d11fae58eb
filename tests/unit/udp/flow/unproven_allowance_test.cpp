#include "udp_transport/flow/unproven_allowance.h"

#include <gtest/gtest.h>

#include <memory>

namespace sft::udp {
namespace {

using namespace std::chrono_literals;

constexpr UnprovenAllowance::Time now{1h};
constexpr FlowLimits limits{.unproven_bytes = 10'000, .unproven_datagrams = 4, .unproven_marks = 2};

TEST(UnprovenAllowanceTest, IsAFewDatagramsAndBytes) {
  UnprovenAllowance allowance(limits, nullptr);
  EXPECT_EQ(allowance.bytes_left(now), 4 * datagram_bytes_min);
  allowance.spend(1000, 3, now);
  EXPECT_EQ(allowance.bytes_left(now), datagram_bytes_min);
  EXPECT_EQ(allowance.datagrams_left(now), 1U);
  allowance.spend(9000, 0, now);
  EXPECT_EQ(allowance.bytes_left(now), 0U);
}

TEST(UnprovenAllowanceTest, IsNoMoreThanTheHostHasLeftAndGoesBackToTheHostOnceProven) {
  const auto host = std::make_shared<UnprovenBudget>();
  UnprovenAllowance allowance(limits, host);
  allowance.spend(100, 1, now);
  host->spend(UnprovenBudget::datagrams_max - 3, now);
  EXPECT_EQ(allowance.datagrams_left(now), 2U);
  allowance.proven();
  EXPECT_EQ(host->left(now), 3U);
}

TEST(UnprovenAllowanceTest, HasSomeMarksOfItsOwnAndThenThoseOfItsHost) {
  const auto host = std::make_shared<UnprovenBudget>();
  UnprovenAllowance allowance(limits, host);
  EXPECT_TRUE(allowance.takes_mark(now) && allowance.takes_mark(now));
  host->spend(UnprovenBudget::datagrams_max, now);
  EXPECT_FALSE(allowance.takes_mark(now));
  allowance.answered(now);
  EXPECT_TRUE(allowance.takes_mark(now)) << "somebody on that host answers";
  allowance.begin_anew(nullptr);
  EXPECT_EQ(allowance.datagrams_left(now), 4U);
}

}  // namespace
}  // namespace sft::udp
