#include "udp_transport/receive/late_filter.h"

#include <gtest/gtest.h>

#include "core/seam/buffer_pool.h"

namespace sft::udp {
namespace {

using core::HistoryProgress;
using namespace std::chrono_literals;

class LateFilterTest : public testing::Test {
 protected:
  static constexpr std::uint64_t us = 7;
  static constexpr std::uint64_t all = 0;

  bool takes(std::uint64_t addressee, std::uint64_t sequence, std::uint32_t ordinal = 0) {
    core::SampleBuffer sample;
    sample.addressee = addressee;
    sample.sequence = sequence;
    sample.min_period_us = ordinal == 0 ? 0 : 1000;
    sample.ordinal = ordinal;
    return filter.takes(sample, now);
  }

  LateFilter filter{true};
  LateFilter::Time now{1h};
};

TEST_F(LateFilterTest, TakesNothingThatIsForAllUntilSomethingForItsReaderAloneHasCome) {
  EXPECT_FALSE(takes(all, 9));
  EXPECT_EQ(filter.progress(now), HistoryProgress::awaited);
  EXPECT_TRUE(takes(us, 5));
  EXPECT_EQ(filter.progress(now), HistoryProgress::coming);
}

TEST_F(LateFilterTest, LetsNothingOvertakeWhatIsUnderWayForItsReaderAlone) {
  takes(us, 5);
  EXPECT_FALSE(takes(all, 9));
  EXPECT_TRUE(takes(us, 6));
  EXPECT_TRUE(takes(all, 7)) << "the very next one";
  EXPECT_TRUE(takes(us, 7)) << "for the queue to tell that it is known";
  EXPECT_TRUE(takes(all, 8));
}

TEST_F(LateFilterTest, TakesAllOnceNothingForItsReaderAloneIsUnderWayAlsoAfterALoss) {
  takes(us, 5);
  now += LateFilter::settling;
  EXPECT_EQ(filter.progress(now), HistoryProgress::came);
  EXPECT_TRUE(takes(all, 9));
  EXPECT_TRUE(takes(all, 11));
}

TEST_F(LateFilterTest, TellsTheNextOneOfALimitedRateByItsOrdinal) {
  takes(us, 5, 3);
  EXPECT_TRUE(takes(all, 15, 4));
  EXPECT_FALSE(takes(all, 35, 6));
}

TEST_F(LateFilterTest, TakesAllWhereNoHistoryIsExpected) {
  filter = LateFilter(false);
  EXPECT_TRUE(takes(all, 9));
  EXPECT_EQ(filter.progress(now), HistoryProgress::came);
}

}  // namespace
}  // namespace sft::udp
