#include "udp_transport/flow/rate_limit.h"

#include <gtest/gtest.h>

namespace sft::udp {
namespace {

using namespace std::chrono_literals;

constexpr bool as_small = true, as_large = false;
constexpr std::size_t burst_bytes = 10'000;

std::size_t send_while_ready(RateLimit& limit, bool is_small, RateLimit::Time now) {
  std::size_t sent = 0;
  for (; sent < 10'000'000 && limit.ready(is_small, now); sent += burst_bytes) limit.spend(burst_bytes);
  return sent;
}

TEST(RateLimitTest, LimitsNothingAtZero) {
  RateLimit none(0);
  EXPECT_GE(send_while_ready(none, as_large, {}), 10'000'000U);
  EXPECT_EQ(none.batch_bytes(), SIZE_MAX);
}

TEST(RateLimitTest, LeavesSomeToSmallSamples) {
  RateLimit limit(10'000'000);
  const RateLimit::Time now{1h};
  EXPECT_GT(send_while_ready(limit, as_large, now), 0U);
  EXPECT_GT(send_while_ready(limit, as_small, now), 0U);
  EXPECT_EQ(send_while_ready(limit, as_large, now), 0U);
}

TEST(RateLimitTest, KeepsTheRateOfAllTogether) {
  RateLimit limit(10'000'000);
  RateLimit::Time now{1h};
  std::size_t sent = 0;
  for (const auto end = now + 1s; now < end;
       now = std::min(limit.next_ready(as_small, now), limit.next_ready(as_large, now)) + 1us) {
    sent += send_while_ready(limit, as_large, now);
    sent += send_while_ready(limit, as_small, now);
  }
  EXPECT_NEAR(static_cast<double>(sent), 10e6, 0.5e6);
}

}  // namespace
}  // namespace sft::udp
