#include "udp_transport/flow/longest_arrivals.h"

#include <gtest/gtest.h>

namespace sft::udp {
namespace {

using namespace std::chrono_literals;

class LongestArrivalsTest : public testing::Test {
 protected:
  static core::IpAddress host(std::size_t number) {
    return core::IpAddress(static_cast<std::uint32_t>(0x0A000000 + number));
  }
  std::uint32_t mark(std::size_t number = 1) { return arrivals_.answer(host(number), 40, now_); }

  LongestArrivals::Time now_{1h};
  LongestArrivals arrivals_;
};

TEST_F(LongestArrivalsTest, KnowsNothingOfAnAddressBeforeItsFirstMark) {
  arrivals_.note(host(1), 1472, now_);
  EXPECT_EQ(mark(), 0U);
  EXPECT_EQ(mark(), 40U) << "the mark itself has come";
}

TEST_F(LongestArrivalsTest, TellsTheLongestOfEachAddress) {
  mark(1), mark(2);
  arrivals_.note(host(1), 1472, now_);
  arrivals_.note(host(1), 100, now_);
  arrivals_.note(host(2), 200, now_);
  EXPECT_EQ(mark(1), 1472U);
  EXPECT_EQ(mark(2), 200U);
  EXPECT_EQ(mark(1), 1472U) << "another mark may have been lost";
}

TEST_F(LongestArrivalsTest, RemembersADatagramForAtLeastAPeriodAndAtMostTwo) {
  for (auto offset = 0ms; offset < 1s; offset += 100ms) {
    mark();
    now_ += offset;
    arrivals_.note(host(1), 1472, now_);
    now_ += LongestArrivals::period - 1ms;
    EXPECT_EQ(mark(), 1472U);
    now_ += LongestArrivals::period + 1ms;
    EXPECT_EQ(mark(), 40U);
  }
}

TEST_F(LongestArrivalsTest, ForgetsAnAddressWithoutMarksForAnotherOneIfThereAreMany) {
  for (std::size_t n = 1; n <= LongestArrivals::addresses_max; ++n) mark(n);
  mark(1000);
  EXPECT_EQ(mark(1000), 0U) << "there is no place for it";
  now_ += LongestArrivals::kept_for + 1s;
  mark(1000);
  EXPECT_EQ(mark(1000), 40U);
}

}  // namespace
}  // namespace sft::udp
