#include "udp_transport/reliable/kept_samples.h"

#include <gtest/gtest.h>

#include <memory>

#include "tests/unit/udp/jobs.h"

namespace sft::udp {
namespace {

using KeptSize = KeptSamples::Size;
using Amount = KeptSamples::Amount;

class KeptSamplesTest : public testing::Test {
 protected:
  explicit KeptSamplesTest(const ResendLimits& limits = {.samples = 4}) : kept(limits, 1, nullptr) {}

  std::uint64_t keep(std::size_t body_bytes = 100, bool elsewhere = false) {
    const JobHandle job = test::make_job(*jobs, 1, body_bytes);
    last = kept.keep(job, job->first, elsewhere);
    return last.ordinal;
  }

  std::shared_ptr<JobPool> jobs = JobPool::make();
  KeptSamples kept;
  KeptSamples::Kept last;
};

TEST_F(KeptSamplesTest, LetsTheOldestGoWhereThereAreTooMany) {
  for (std::uint64_t ordinal = 1; ordinal <= 4; ++ordinal) {
    EXPECT_TRUE(kept.can_keep(1, 0));
    EXPECT_EQ(keep(), ordinal);
  }
  EXPECT_FALSE(kept.can_keep(1, 0));
  kept.begin_sending(1);
  keep();
  EXPECT_EQ(last.unacknowledged, 1U);
  EXPECT_EQ(last.dropped, 0U);
  keep();
  EXPECT_EQ(last.dropped, 1U) << "the second one was never sent";
  EXPECT_EQ(kept.begin(), 3U);
}

TEST_F(KeptSamplesTest, HaveAQueueForEachSize) {
  keep(100'000);
  keep(100);
  EXPECT_EQ(kept.first_waiting(KeptSize::large), 1U);
  EXPECT_EQ(kept.first_waiting(KeptSize::small), 2U);
  kept.begin_sending(2);
  EXPECT_EQ(kept.first_waiting(KeptSize::small), kept.end());
}

TEST_F(KeptSamplesTest, WaitAgainFromWhereTheyWerePutBack) {
  keep();
  kept.begin_sending(1);
  EXPECT_EQ(kept.first_waiting(KeptSize::small), 2U);
  kept.put_back(1, 1, 60);
  EXPECT_EQ(kept.first_waiting(KeptSize::small), 1U);
  EXPECT_EQ(kept[1].sent_bytes, 60U);
}

TEST_F(KeptSamplesTest, KnowHowManyWereSentWithoutAGap) {
  for (int i = 0; i < 3; ++i) keep();
  for (const std::uint64_t ordinal : {1U, 2U, 3U}) kept.begin_sending(ordinal);
  kept.sent(2, 1);
  EXPECT_EQ(kept.sent_end(), 1U);
  kept.sent(1, 1);
  EXPECT_EQ(kept.sent_end(), 3U);
}

TEST_F(KeptSamplesTest, StayUntilTheyHaveBegunHoweverMuchIsAcknowledged) {
  for (int i = 0; i < 3; ++i) keep();
  kept.begin_sending(1);
  kept.release_before(4);
  EXPECT_EQ(kept.begin(), 2U);
}

TEST_F(KeptSamplesTest, AreSentElsewhereWhileAtMostHalfIsKept) {
  keep(100, true);
  EXPECT_TRUE(last.elsewhere);
  EXPECT_EQ(kept.first_waiting(KeptSize::small), kept.end());
  EXPECT_EQ(kept.departed(1), true);
  EXPECT_EQ(kept.departed(1), false) << "a second time";
  for (int i = 0; i < 2; ++i) keep();
  EXPECT_EQ(kept.amount(), Amount::more_than_half);
  EXPECT_EQ(kept.departed(2), std::nullopt) << "that one is sent here";
  keep(100, true);
  EXPECT_FALSE(last.elsewhere);
}

class KeptSamplesOfFewBytesTest : public KeptSamplesTest {
 protected:
  static constexpr std::size_t most = 100'000, beyond_half = 60'000;
  KeptSamplesOfFewBytesTest() : KeptSamplesTest(ResendLimits::of_at_most(most)) {}
};

TEST_F(KeptSamplesOfFewBytesTest, ALargeSampleIsSentElsewhereUnlessTheOneBeforeItIsKeptToo) {
  for (int i = 0; i < 3; ++i) {
    const std::uint64_t ordinal = keep(beyond_half, true);
    EXPECT_TRUE(last.elsewhere);
    EXPECT_EQ(kept.amount(), Amount::at_most_half);
    kept.departed(ordinal);
    kept.release_before(ordinal + 1);
  }
  keep(beyond_half);
  keep(beyond_half, true);
  EXPECT_EQ(kept.amount(), Amount::more_than_half) << "two of the three that are kept in any case";
  EXPECT_FALSE(last.elsewhere);
}

TEST_F(KeptSamplesOfFewBytesTest, SamplesOfMoreThanHalfOfTheBytesAreNotSentElsewhere) {
  for (std::size_t bytes = 0; bytes + 6'000 <= most / 2; bytes += 6'000) {
    keep(6'000, true);
    EXPECT_TRUE(last.elsewhere) << bytes;
  }
  keep(6'000, true);
  EXPECT_FALSE(last.elsewhere);
}

}  // namespace
}  // namespace sft::udp
