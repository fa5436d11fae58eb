#include "udp_transport/reliable/length_watch.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "tests/unit/udp/jobs.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t length = 1400;
constexpr std::size_t thumbnail_bytes = 100, whole_image_bytes = 10'000;

class LengthWatchTest : public testing::Test {
 protected:
  LengthWatchTest() { judge(1); }  // it learns the length

  void send(std::size_t bytes) {
    const JobHandle job = test::make_job(*jobs, window.end(), bytes);
    const auto kept = window.keep(job, job->first);
    window.finished(*window.take(kept.ordinal), now);
  }
  LengthWatch::Verdict judge(std::uint64_t next, const std::vector<Missing>& missing = {},
                             std::size_t of_length = length) {
    Ack ack{.writer = 1, .channel = 1, .next = next};
    for (const Missing& part : missing) ack.missing[ack.missing_count++] = part;
    const LengthWatch::Verdict verdict = watch.judge(ack, window, of_length, in_doubt);
    window.hear(ack, now);
    return verdict;
  }

  std::shared_ptr<JobPool> jobs = JobPool::make();
  ResendWindow::Time now{1h};
  ResendWindow window{1, 1, ResendLimits{}};
  bool in_doubt = true;
  LengthWatch watch;
};

TEST_F(LengthWatchTest, TellsThatLongDatagramsArriveOnceALongSampleIsAcknowledged) {
  send(thumbnail_bytes);
  send(whole_image_bytes);
  EXPECT_FALSE(judge(2).arrived) << "the small sample is no proof";
  EXPECT_TRUE(judge(3).arrived);
  EXPECT_FALSE(judge(3).arrived) << "nothing new arrived";
}

TEST_F(LengthWatchTest, TellsNothingOfArrivalsWhileNobodyDoubtsThem) {
  in_doubt = false;
  send(whole_image_bytes);
  EXPECT_FALSE(judge(2).arrived);
}

TEST_F(LengthWatchTest, TakesNoSampleOfAnotherLengthForAProof) {
  send(whole_image_bytes);
  EXPECT_FALSE(judge(2, {}, length + 100).arrived) << "it was sent in shorter datagrams";
  send(whole_image_bytes);
  EXPECT_TRUE(judge(3, {}, length + 100).arrived);
}

TEST_F(LengthWatchTest, TellsThatLongDatagramsWereLostIfAllOfALongSampleIsAskedFor) {
  send(whole_image_bytes);
  EXPECT_TRUE(judge(1, {{1, 0, 0}}).lost);
  EXPECT_TRUE(judge(1, {{1, 0, whole_image_bytes}}).lost) << "the last datagram is short";
}

TEST_F(LengthWatchTest, TellsOfNoLossIfAPartOfTheSampleArrived) {
  send(whole_image_bytes);
  EXPECT_FALSE(judge(1, {{1, 5000, 0}}).lost);
  EXPECT_FALSE(judge(1, {{1, 0, 5000}}).lost);
}

TEST_F(LengthWatchTest, TellsOfNoLossOfLongDatagramsIfASmallSampleIsAskedFor) {
  send(thumbnail_bytes);
  EXPECT_FALSE(judge(1, {{1, 0, 0}}).lost);
}

TEST_F(LengthWatchTest, LooksOnlyAtTheSampleThatIsMissingFirst) {
  send(thumbnail_bytes);
  send(whole_image_bytes);
  EXPECT_FALSE(judge(1, {{1, 0, 0}, {2, 0, 0}}).lost) << "even a short datagram was lost";
}

TEST_F(LengthWatchTest, TellsOfNoLossOfASampleThatWasNotSent) {
  const JobHandle job = test::make_job(*jobs, 1, whole_image_bytes);
  window.keep(job, job->first);
  EXPECT_FALSE(judge(1, {{1, 0, 0}}).lost);
}

}  // namespace
}  // namespace sft::udp
