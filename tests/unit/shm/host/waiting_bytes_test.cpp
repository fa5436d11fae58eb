// How many samples may wait where their bytes are limited.
#include "shm_transport/host/waiting_bytes.h"

#include <gtest/gtest.h>

#include <deque>
#include <random>

namespace sft::shm {
namespace {

TEST(WaitingBytesTest, AnyNumberMayWaitWithoutALimit) {
  WaitingBytes bytes;
  bytes.pushed(UINT64_MAX / 2);
  EXPECT_EQ(bytes.beside(UINT64_MAX / 2), WaitingBytes::any_number);
}

TEST(WaitingBytesTest, AnyNumberMayWaitOfWhatWasSentAsLongAsAllOfItFits) {
  WaitingBytes bytes(100, 8);
  EXPECT_EQ(bytes.beside(100), WaitingBytes::any_number);
  bytes.pushed(60);
  EXPECT_EQ(bytes.beside(40), WaitingBytes::any_number);
  EXPECT_EQ(bytes.beside(41), 0U);
}

TEST(WaitingBytesTest, TheNewestOnesMayWait) {
  WaitingBytes bytes(100, 8);
  for (const std::uint64_t size : {90U, 30U, 20U, 10U}) bytes.pushed(size);
  EXPECT_EQ(bytes.beside(40), 3U);
  EXPECT_EQ(bytes.beside(41), 2U);
  EXPECT_EQ(bytes.beside(70), 2U);
  EXPECT_EQ(bytes.beside(90), 1U);
  EXPECT_EQ(bytes.beside(91), 0U);
}

TEST(WaitingBytesTest, ASampleThatIsLargerThanTheLimitWaitsAlone) {
  WaitingBytes bytes(100, 8);
  bytes.pushed(1);
  EXPECT_EQ(bytes.beside(1000), 0U);
  bytes.pushed(1000);
  EXPECT_EQ(bytes.beside(1), 0U);
}

TEST(WaitingBytesTest, TheNumberIsThatOfTheNewestThatFitWhateverTheirSizes) {
  constexpr std::size_t kept = 16;
  constexpr std::uint64_t most = 1000;
  std::mt19937 random(7);
  WaitingBytes bytes(most, kept);
  std::deque<std::uint64_t> newest;  // the newest one first
  for (int i = 0; i < 2000; ++i) {
    const std::uint64_t next = random() % 400;
    std::uint64_t sum = next, fit = 0;
    while (fit < newest.size() && sum + newest[fit] <= most) sum += newest[fit++];
    const bool all = fit == newest.size();
    ASSERT_EQ(bytes.beside(next), all ? WaitingBytes::any_number : fit) << i;
    bytes.pushed(next);
    newest.push_front(next);
    if (newest.size() > kept) newest.pop_back();
  }
}

}  // namespace
}  // namespace sft::shm
