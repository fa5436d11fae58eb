// The number of samples that count as lost in a queue of shared memory.
#include "shm_transport/ports/loss_account.h"

#include <gtest/gtest.h>

namespace sft::shm {
namespace {

class LossAccountTest : public ::testing::Test {
 protected:
  /// Takes the sample with that sequence. Returns the number of samples that were lost before it.
  std::uint64_t takes(std::uint64_t sequence) {
    return account.enter(sequence, ++popped_, [] { return std::uint64_t{2}; });
  }

  LossAccount account;

 private:
  std::uint64_t popped_ = 0;
};

TEST_F(LossAccountTest, AGapWithoutAnOverflowIsNoLoss) {
  EXPECT_EQ(takes(1), 0U);
  EXPECT_EQ(takes(5), 0U) << "the samples took another way";
}

TEST_F(LossAccountTest, AnOverflowBeforeTheFirstSampleLosesOneAtLeast) {
  EXPECT_TRUE(account.nothing_came_before());
  account.overflowed();
  EXPECT_FALSE(account.nothing_came_before());
  EXPECT_EQ(takes(7), 1U);
}

TEST_F(LossAccountTest, AnOverflowExplainsTheGap) {
  takes(1);
  account.overflowed();
  EXPECT_EQ(takes(5), 3U);
  EXPECT_EQ(takes(6), 0U) << "the samples are counted once";
}

TEST_F(LossAccountTest, AnOverflowThatIsReportedLateExplainsAGapForAsLongAsAQueueOfSamples) {
  takes(1);
  takes(5);
  takes(6);
  account.overflowed();
  EXPECT_EQ(takes(7), 3U);
}

TEST_F(LossAccountTest, AnOverflowThatIsReportedTooLateExplainsNothing) {
  takes(1);
  takes(5);
  for (std::uint64_t sequence = 6; sequence <= 9; ++sequence) takes(sequence);
  account.overflowed();
  EXPECT_EQ(takes(10), 0U);
}

TEST_F(LossAccountTest, OnlySamplesDroppedAtTheBeginAndAtTheEndAreWithoutAGap) {
  account.dropped();
  takes(2);
  EXPECT_EQ(account.lost_unnoticed(), 1U);
  account.dropped();
  EXPECT_EQ(account.lost_unnoticed(), 2U);
  takes(4);
  EXPECT_EQ(account.lost_unnoticed(), 1U) << "a gap shows the other one";
}

}  // namespace
}  // namespace sft::shm
