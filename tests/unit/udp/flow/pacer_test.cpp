#include "udp_transport/flow/pacer.h"

#include <gtest/gtest.h>

namespace sft::udp {
namespace {

using namespace std::chrono_literals;

/// Sends like the sending thread, in simulated time.
class PacerTest : public testing::Test {
 protected:
  static constexpr std::size_t batch_bytes = 64'000;

  /// Returns the number of bytes that are sent before the pacer makes the sender wait.
  std::size_t send_while_ready(Pacer& pacer, std::size_t at_most) {
    std::size_t sent = 0;
    while (sent < at_most && pacer.ready(now_)) {
      pacer.spend(batch_bytes);
      sent += batch_bytes;
    }
    return sent;
  }

  std::size_t send_for(Pacer& pacer, std::chrono::milliseconds time) {
    std::size_t sent = 0;
    for (const Pacer::Time end = now_ + time; now_ < end; now_ = pacer.next_ready(now_) + 1us) {
      sent += send_while_ready(pacer, 100'000'000);
    }
    return sent;
  }

  Pacer::Time now_ = Pacer::Time{} + 1h;
};

TEST_F(PacerTest, LetsABurstGoAndNotMuchMore) {
  Pacer pacer(600'000'000, 4'000'000);
  const std::size_t sent = send_while_ready(pacer, 100'000'000);
  EXPECT_GE(sent, 4'000'000U);
  EXPECT_LE(sent, 4'000'000U + batch_bytes);
}

TEST_F(PacerTest, KeepsTheRateAfterTheBurst) {
  Pacer pacer(600'000'000, 4'000'000);
  send_while_ready(pacer, 100'000'000);
  EXPECT_NEAR(static_cast<double>(send_for(pacer, 100ms)), 60e6, 1e6);
}

TEST_F(PacerTest, RestsBetweenBatchesOfABigBuffer) {
  Pacer pacer(600'000'000, 4'000'000);
  send_while_ready(pacer, 100'000'000);
  EXPECT_GT(pacer.next_ready(now_) - now_, 300us);
}

TEST_F(PacerTest, LeavesAReserveToOthers) {
  Pacer pacer(600'000'000, 4'000'000);
  while (pacer.ready(now_, 1'000'000)) pacer.spend(batch_bytes);
  EXPECT_GE(send_while_ready(pacer, 100'000'000), 1'000'000U - batch_bytes);
  EXPECT_TRUE(pacer.ready(pacer.next_ready(now_, 1'000'000) + 1us, 1'000'000));
}

TEST_F(PacerTest, AllowsAnotherBurstAfterAPause) {
  Pacer pacer(600'000'000, 4'000'000);
  send_while_ready(pacer, 100'000'000);
  now_ += 1s;
  EXPECT_GE(send_while_ready(pacer, 100'000'000), 4'000'000U);
}

TEST_F(PacerTest, KnowsWhenToGoOnWhateverTheBurst) {
  for (const std::size_t burst : {0UL, 1UL, 1000UL, 4'000'000'000UL}) {
    Pacer pacer(600'000'000, burst);
    pacer.ready(now_);
    pacer.spend(2 * burst + batch_bytes);
    EXPECT_GT(pacer.next_ready(now_), now_) << burst;
    EXPECT_TRUE(pacer.ready(pacer.next_ready(now_) + 1us)) << burst;
  }
  EXPECT_GE(Pacer(600'000'000, 1).next_ready(now_), now_);
}

TEST_F(PacerTest, LimitsNothingAtRateZero) {
  Pacer pacer(0, 1000);
  EXPECT_GE(send_while_ready(pacer, 100'000'000), 100'000'000U);
  EXPECT_EQ(pacer.next_ready(now_), now_);
}

}  // namespace
}  // namespace sft::udp
