// Finds the sample of each answer, and keeps stalls of the sender out of the figures.
#include "tools/perf/sequence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sft::perf {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(AnsweredTest, OnePartLastsUntilASampleIsMissing) {
  Answered answered;
  for (const std::uint64_t sample : {1, 2, 3, 5, 6}) answered.note(sample);
  EXPECT_THAT(answered.take_parts(), ElementsAre(Part{1, 1}, Part{4, 5}));
  answered.note(7);
  EXPECT_THAT(answered.take_parts(), IsEmpty());
  answered.note(4);
  EXPECT_THAT(answered.take_parts(), ElementsAre(Part{7, 4}));
}

TEST(AnsweredTest, AnAnswerBelongsToTheSampleOfItsPart) {
  const std::vector<Part> parts{{1, 1}, {4, 5}, {7, 4}};
  EXPECT_EQ(sample_of(3, parts), 3U);
  EXPECT_EQ(sample_of(4, parts), 5U);
  EXPECT_EQ(sample_of(6, parts), 7U);
  EXPECT_EQ(sample_of(7, parts), 4U);
  EXPECT_EQ(sample_of(1, {}), 0U) << "no report has come yet";
}

TEST(TallyTest, TwiceAndReorderedAreCountedApart) {
  Tally tally;
  for (const std::uint64_t number : {1, 2, 4, 3, 4, 6}) tally.note(number);
  EXPECT_EQ(tally.distinct(), 5U);
  EXPECT_EQ(tally.twice(), 1U);
  EXPECT_EQ(tally.reordered(), 1U);
}

TEST(ScheduleTest, AStallCountsForAllSamplesThatWereDue) {
  bool late = false;
  EXPECT_EQ(counted_from(1000, 61'000, 10'000'000, late), 61'000) << "a thread takes a while to wake up";
  EXPECT_FALSE(late);
  EXPECT_EQ(counted_from(1000, 30'000'000, 10'000'000, late), 1000);
  EXPECT_TRUE(late);
  EXPECT_EQ(counted_from(0, 200'000, 100'000, late), 0) << "the next one was due already";
  EXPECT_TRUE(late);
}

}  // namespace
}  // namespace sft::perf
