// The maximum number of samples that may wait if their bytes are limited.
#include "shm_transport/host/waiting_bytes.h"

#include <gtest/gtest.h>

#include <deque>
#include <random>

namespace sft::shm {
namespace {

TEST(WaitingBytesTest, AnyNumberMayWaitWithoutALimit) {
  WaitingBytes waiting;
  waiting.pushed(UINT64_MAX / 2);
  EXPECT_EQ(waiting.beside(UINT64_MAX / 2), WaitingBytes::any_number);
}

TEST(WaitingBytesTest, AnyNumberMayWaitOfWhatWasSentAsLongAsAllOfItFits) {
  WaitingBytes waiting(100, 8);
  EXPECT_EQ(waiting.beside(100), WaitingBytes::any_number);
  waiting.pushed(60);
  EXPECT_EQ(waiting.beside(40), WaitingBytes::any_number);
  EXPECT_EQ(waiting.beside(41), 0U);
}

TEST(WaitingBytesTest, TheNewestOnesMayWait) {
  WaitingBytes waiting(100, 8);
  for (const std::uint64_t size : {90U, 30U, 20U, 10U}) waiting.pushed(size);
  EXPECT_EQ(waiting.beside(40), 3U);
  EXPECT_EQ(waiting.beside(41), 2U);
  EXPECT_EQ(waiting.beside(70), 2U);
  EXPECT_EQ(waiting.beside(90), 1U);
  EXPECT_EQ(waiting.beside(91), 0U);
}

TEST(WaitingBytesTest, ASampleThatIsLargerThanTheLimitWaitsAlone) {
  WaitingBytes waiting(100, 8);
  waiting.pushed(1);
  EXPECT_EQ(waiting.beside(1000), 0U);
  waiting.pushed(1000);
  EXPECT_EQ(waiting.beside(1), 0U);
}

TEST(WaitingBytesTest, TheNumberIsThatOfTheNewestThatFitWhateverTheirSizes) {
  constexpr std::size_t kept = 16;
  constexpr std::uint64_t most = 1000;
  std::mt19937 random(7);
  WaitingBytes waiting(most, kept);
  std::deque<std::uint64_t> newest;  // the newest sample first
  for (int i = 0; i < 2000; ++i) {
    const std::uint64_t next = random() % 400;
    std::uint64_t sum = next, fit = 0;
    while (fit < newest.size() && sum + newest[fit] <= most) sum += newest[fit++];
    const bool all = fit == newest.size();
    ASSERT_EQ(waiting.beside(next), all ? WaitingBytes::any_number : fit) << i;
    waiting.pushed(next);
    newest.push_front(next);
    if (newest.size() > kept) newest.pop_back();
  }
}

}  // namespace
}  // namespace sft::shm
