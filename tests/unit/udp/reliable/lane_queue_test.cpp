#include "udp_transport/reliable/lane_queue.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "tests/unit/udp/jobs.h"

namespace sft::udp {
namespace {

class LaneQueueTest : public testing::Test {
 protected:
  using Numbers = std::vector<std::uint64_t>;

  JobHandle job(std::uint64_t sequence) { return test::make_job(*jobs_, sequence); }
  JobHandle for_late_reader(std::uint64_t sequence) {
    JobHandle one = job(sequence);
    one->first.flags = history_follows;
    return one;
  }
  void post(const Numbers& sequences) {
    for (const std::uint64_t sequence : sequences) queue_.post(job(sequence));
  }
  void put_first(const Numbers& sequences) {
    std::vector<JobHandle> retained;
    for (const std::uint64_t sequence : sequences) retained.push_back(for_late_reader(sequence));
    queue_.put_first(std::move(retained));
  }
  Numbers take_all() {
    Numbers sequences;
    while (const JobHandle next = queue_.take().job) sequences.push_back(next->sequence);
    return sequences;
  }

  std::shared_ptr<JobPool> jobs_ = JobPool::make();
  const std::size_t job_bytes_ = job(1)->held_bytes_in_all();
  LaneQueue queue_{2, {.jobs = 5, .bytes = 4 * job_bytes_}};
};

TEST_F(LaneQueueTest, GivesOutWhatWasPostedTheOldestFirst) {
  EXPECT_TRUE(queue_.empty());
  EXPECT_FALSE(queue_.take().job);
  post({1, 2, 3});
  EXPECT_FALSE(queue_.empty());
  EXPECT_EQ(queue_.pop_oldest()->sequence, 1U);
  EXPECT_EQ(take_all(), (Numbers{2, 3}));
  EXPECT_TRUE(queue_.empty());
}

TEST_F(LaneQueueTest, GivesOutRetainedSamplesBeforeWhatWasPosted) {
  post({5});
  put_first({3, 4});
  EXPECT_TRUE(queue_.take().is_retained);
  EXPECT_TRUE(queue_.take().is_retained);
  EXPECT_FALSE(queue_.empty());
  const LaneQueue::Next last = queue_.take();
  EXPECT_FALSE(last.is_retained);
  EXPECT_EQ(last.job->sequence, 5U);
}

TEST_F(LaneQueueTest, KeepsTheOrderOfRetainedSamples) {
  put_first({1, 2, 3});
  post({4});
  EXPECT_EQ(take_all(), (Numbers{1, 2, 3, 4}));
}

TEST_F(LaneQueueTest, HasRoomUntilAsManyArePostedAsItIsDeep) {
  put_first({1, 2, 3});
  EXPECT_TRUE(queue_.has_room()) << "retained samples take no room";
  post({4});
  EXPECT_TRUE(queue_.has_room());
  post({5});
  EXPECT_FALSE(queue_.has_room());
  queue_.pop_oldest();
  EXPECT_TRUE(queue_.has_room());
}

TEST_F(LaneQueueTest, HasRoomForOneAtLeast) {
  LaneQueue queue(0, {});
  EXPECT_TRUE(queue.has_room());
  queue.post(job(1));
  EXPECT_FALSE(queue.has_room());
}

TEST_F(LaneQueueTest, HasRoomBeyondItsDepthForSoManyBytes) {
  const JobHandle next = job(9);
  EXPECT_EQ(queue_.bytes_with(*next), job_bytes_);
  post({1, 2, 3});
  EXPECT_EQ(queue_.bytes_with(*next), 4 * job_bytes_);
  EXPECT_TRUE(queue_.has_room_beyond_depth(*next));
  post({4});
  EXPECT_FALSE(queue_.has_room_beyond_depth(*next));
  queue_.take();
  EXPECT_TRUE(queue_.has_room_beyond_depth(*next));
}

TEST_F(LaneQueueTest, HasRoomBeyondItsDepthForSoManyJobs) {
  LaneQueue queue(2, {.jobs = 3, .bytes = SIZE_MAX});
  for (std::uint64_t n = 1; n <= 2; ++n) queue.post(job(n));
  EXPECT_TRUE(queue.has_room_beyond_depth(*job(9)));
  queue.post(job(3));
  EXPECT_FALSE(queue.has_room_beyond_depth(*job(9)));
}

TEST_F(LaneQueueTest, TellsLateReadersWhichSampleWasTheFirst) {
  queue_.post(for_late_reader(7));
  put_first({5, 6});
  while (const JobHandle next = queue_.take().job)
    EXPECT_EQ(next->first.history.oldest, 5U) << next->sequence;
  const JobHandle direct = for_late_reader(8);
  queue_.mark(*direct);
  EXPECT_EQ(direct->first.history.oldest, 5U);
}

TEST_F(LaneQueueTest, CountsFromTheFirstPostedSampleIfNothingIsRetained) {
  queue_.post(for_late_reader(7));
  put_first({});
  queue_.post(for_late_reader(8));
  queue_.pop_oldest();
  EXPECT_EQ(queue_.take().job->first.history.oldest, 7U);
}

TEST_F(LaneQueueTest, CountsFromASampleThatWasSentWithoutBeingQueued) {
  queue_.mark(*for_late_reader(4));
  queue_.post(for_late_reader(5));
  EXPECT_EQ(queue_.take().job->first.history.oldest, 4U);
}

TEST_F(LaneQueueTest, TellsOtherReadersNothingOfTheFirstSample) {
  post({7});
  EXPECT_EQ(queue_.take().job->first.history.oldest, 0U);
}

TEST_F(LaneQueueTest, HandsOutEverythingWhenItIsCleared) {
  put_first({1});
  post({2, 3});
  LaneQueue::Contents contents = queue_.clear();
  EXPECT_EQ(contents.retained.size(), 1U);
  ASSERT_EQ(contents.posted.size(), 2U);
  EXPECT_EQ(contents.posted[contents.posted.begin()]->sequence, 2U);
  EXPECT_TRUE(queue_.empty());
  EXPECT_TRUE(queue_.has_room());
  EXPECT_EQ(queue_.bytes_with(*job(9)), job_bytes_);
}

}  // namespace
}  // namespace sft::udp
