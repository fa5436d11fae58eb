#include "udp_transport/reliable/arrived_samples.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "core/seam/buffer_pool.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;

class ArrivedSamplesTest : public testing::Test {
 protected:
  core::SampleHandle sample(std::uint64_t sequence) {
    core::SampleHandle made = memory->take(1000);
    made->sequence = sequence;
    bytes_each = made->capacity;
    return made;
  }

  const ArrivedSamples::Time now{1h};
  std::shared_ptr<core::BufferPool> memory = core::BufferPool::make(std::size_t{1} << 20);
  std::size_t bytes_each = sample(1)->capacity;
  ArrivedSamples samples{{.samples = 10, .held_bytes = 2 * bytes_each}};
};

TEST_F(ArrivedSamplesTest, HasEverythingBeforeNextWhole) {
  EXPECT_TRUE(samples.reach(4, now));
  EXPECT_TRUE(samples.whole(2, sample(2)));
  EXPECT_EQ(samples.next(), 1U);
  EXPECT_TRUE(samples.whole(1, sample(1)));
  EXPECT_EQ(samples.next(), 3U);
  samples.pass(3);
  EXPECT_EQ(samples.next(), 4U);
}

TEST_F(ArrivedSamplesTest, KnowsOfMoreThanThereIsRoomFor) {
  EXPECT_FALSE(samples.reach(20, now));
  EXPECT_EQ(samples.slots().size(), 10U);
  EXPECT_EQ(samples.end(), 20U);
}

TEST_F(ArrivedSamplesTest, CountsTheBytesOfWholeSamplesUntilTheyAreReleased) {
  samples.reach(3, now);
  samples.begun(1, {}, sample(1));
  EXPECT_EQ(samples.held_bytes(), 0U);
  samples.whole(1, sample(1));
  samples.whole(2, sample(2));
  EXPECT_EQ(samples.held_bytes(), 2 * bytes_each);
  samples.distrust_above(1);
  EXPECT_EQ(samples.held_bytes(), bytes_each);
  samples.release_before(3);
  EXPECT_EQ(samples.held_bytes(), 0U);
}

/// A sample counts as held back only while an earlier sample is missing.
TEST_F(ArrivedSamplesTest, HoldsNoMoreBackForSamplesThatTurnedOutWrong) {
  samples.reach(9, now);
  samples.whole(1, sample(51));
  samples.whole(2, sample(52));
  samples.distrust_above(50);
  samples.release_before(3);
  for (ArrivedSamples::Place place = 4; place <= 6; ++place) samples.whole(place, sample(place));
  EXPECT_EQ(samples.next(), 3U);
  samples.hold_no_more_than_allowed();
  EXPECT_EQ(samples.next(), 7U) << "two may be held back, and the third one was given up";
}

/// If these samples stayed known, samples that the writer publishes later at the same places would be
/// discarded.
TEST_F(ArrivedSamplesTest, ForgetsWhatTheWriterInsistsThatItHasNotPublished) {
  samples.reach(6, now);
  samples.whole(3, sample(3));
  samples.whole(4, sample(4));
  samples.pass(5);
  samples.forget_unpublished(4, now);
  samples.forget_unpublished(4, now + 249ms);
  EXPECT_EQ(samples.end(), 6U) << "the samples may have overtaken the heartbeat";
  samples.forget_unpublished(4, now + 250ms);
  EXPECT_EQ(samples.end(), 4U);
  EXPECT_EQ(samples.slots().end(), 4U);
  EXPECT_EQ(samples.held_bytes(), bytes_each) << "the third was published";
}

TEST_F(ArrivedSamplesTest, KeepsSamplesThatTheWriterPublishesSoonAfterItHasDeniedThem) {
  samples.reach(6, now);
  samples.whole(4, sample(4));
  samples.whole(5, sample(5));
  samples.forget_unpublished(4, now);
  samples.forget_unpublished(6, now + 1s);
  EXPECT_EQ(samples.end(), 6U);
  samples.reach(7, now + 1s);
  samples.forget_unpublished(6, now + 2s);
  EXPECT_EQ(samples.end(), 7U) << "of this place the writer has said it only once";
}

TEST_F(ArrivedSamplesTest, LosesTheOldestWhereTooMuchIsHeldBackBehindIt) {
  const SampleLabel label{1, 1, 0};
  samples.reach(6, now);
  samples.begun(1, label, sample(1));
  for (const std::uint64_t place : {2U, 4U, 5U}) samples.whole(place, sample(place));
  samples.hold_no_more_than_allowed();
  EXPECT_EQ(samples.next(), 3U) << "two are held back behind the third: that is allowed";
  EXPECT_EQ(samples.lost(), 1U);
  EXPECT_EQ(samples.dropped().abandoned, (std::vector<SampleLabel>{label}));
}

TEST_F(ArrivedSamplesTest, CountsWhatItNeverKnewOfAsLostOnlyIfItIsTold) {
  samples.reach(2, now);
  samples.lose_before(5, false);
  EXPECT_EQ(samples.lost(), 1U);
  samples.lose_before(8, true);
  EXPECT_EQ(samples.lost(), 4U);
  EXPECT_EQ(samples.first_wanted(), 8U);
}

TEST_F(ArrivedSamplesTest, DoesNotTakeASampleThatIsLost) {
  samples.reach(2, now);
  samples.lose_before(2, true);
  EXPECT_FALSE(samples.whole(1, sample(1)));
  EXPECT_EQ(samples.held_bytes(), 0U);
}

TEST_F(ArrivedSamplesTest, RemembersWhichSamplesMadeNoSense) {
  samples.reach(2, now);
  EXPECT_FALSE(samples.makes_no_sense_again(1));
  EXPECT_TRUE(samples.makes_no_sense_again(1));
}

}  // namespace
}  // namespace sft::udp
