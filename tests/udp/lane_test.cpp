#include "udp_transport/lane.h"

#include <gtest/gtest.h>

#include <vector>

#include "connections.h"
#include "core/buffer_pool.h"

namespace sft::udp {
namespace {

class LaneTest : public testing::Test {
 protected:
  using Numbers = std::vector<std::uint32_t>;

  JobHandle job(std::uint32_t number) {
    JobHandle job = jobs_->take();
    job->sample = memory_->take(1000);
    job->first = {};
    job->first.label.sequence = number;
    return job;
  }
  JobHandle retained(std::uint32_t number) {
    JobHandle retained = job(number);
    retained->first.flags = history_follows;
    return retained;
  }
  std::vector<JobHandle> all_retained(const Numbers& numbers) {
    std::vector<JobHandle> jobs;
    for (const std::uint32_t number : numbers) jobs.push_back(retained(number));
    return jobs;
  }
  static Numbers take_all(Lane& lane) {
    Numbers numbers;
    while (const Job* job = lane.next()) numbers.push_back(job->first.label.sequence);
    return numbers;
  }
  /// Samples that somebody holds.
  std::size_t held() {
    std::vector<core::SampleHandle> rest;
    while (core::SampleHandle free = memory_->take(1000)) rest.push_back(std::move(free));
    return samples - rest.size();
  }

  static constexpr std::size_t samples = 10;
  std::shared_ptr<core::BufferPool> memory_ = core::BufferPool::make(samples * (1024 + 128));
  std::shared_ptr<JobPool> jobs_ = JobPool::make();
  test::Connections connections_;
  DestinationDirectory destinations_{{}, connections_.connect()};
  std::shared_ptr<WriterTally> tally_ = std::make_shared<WriterTally>();
  Lane one_{destinations_.find({.ipv4 = 0x7F000001, .port = 1}), 3, tally_};
  Lane other_{destinations_.find({.ipv4 = 0x7F000001, .port = 2}), 3, tally_};
};

TEST_F(LaneTest, IsIdleUntilSomethingIsPostedAndOnceAllIsTaken) {
  EXPECT_TRUE(one_.idle());
  EXPECT_TRUE(one_.post(job(1)).was_idle);
  EXPECT_FALSE(one_.post(job(2)).was_idle);
  EXPECT_FALSE(one_.idle());
  EXPECT_EQ(take_all(one_), (Numbers{1, 2}));
  EXPECT_TRUE(one_.idle());
}

TEST_F(LaneTest, KeepsTheNewest) {
  for (std::uint32_t n = 1; n <= 3; ++n) EXPECT_FALSE(one_.post(job(n)).dropped_oldest);
  EXPECT_TRUE(one_.post(job(4)).dropped_oldest);
  EXPECT_EQ(take_all(one_), (Numbers{2, 3, 4}));
}

TEST_F(LaneTest, SkipsNothingForADestinationThatFallsBehind) {
  for (std::uint32_t n = 1; n <= 6; ++n) {
    const JobHandle shared = job(n);
    EXPECT_FALSE(one_.post(shared).dropped_oldest);
    EXPECT_EQ(other_.post(shared).dropped_oldest, n > 3);
    EXPECT_EQ(take_all(one_), Numbers{n});
  }
  EXPECT_EQ(take_all(other_), (Numbers{4, 5, 6}));
}

TEST_F(LaneTest, HoldsASampleUntilTheLastLaneIsDoneWithIt) {
  {
    const JobHandle shared = job(1);
    one_.post(shared);
    other_.post(shared);
  }
  take_all(one_);
  EXPECT_EQ(held(), 1U);
  other_.next();
  EXPECT_EQ(held(), 1U) << "it is being sent";
  other_.next();
  EXPECT_EQ(held(), 0U);
}

TEST_F(LaneTest, HoldsNoMoreSamplesThanItsQueueIsDeep) {
  for (std::uint32_t n = 1; n <= 100; ++n) one_.post(job(n));
  EXPECT_EQ(held(), 3U);
}

TEST_F(LaneTest, DropsWhatIsQueuedWhenItIsClosedAndTakesNothingMore) {
  one_.post(job(1));
  one_.post(job(2));
  one_.next();
  one_.close();
  EXPECT_EQ(held(), 1U) << "what is being sent";
  EXPECT_FALSE(one_.post(job(3)).dropped_oldest);
  EXPECT_EQ(take_all(one_), Numbers{});
  EXPECT_EQ(held(), 0U);
}

TEST_F(LaneTest, SendsRetainedSamplesHoweverManyBeforeWhatWaitedForThem) {
  one_.hold();
  EXPECT_FALSE(one_.idle());
  EXPECT_FALSE(one_.post(job(5)).was_idle) << "it cannot go yet";
  EXPECT_TRUE(one_.release(all_retained({1, 2, 3, 4})));
  EXPECT_EQ(tally_->history_waiting, 4U);
  EXPECT_FALSE(one_.post(job(6)).was_idle);
  EXPECT_EQ(take_all(one_), (Numbers{1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(tally_->history_waiting, 0U);
  EXPECT_TRUE(one_.idle());
}

TEST_F(LaneTest, WaitsUntilTheLastReaderThatHeldItHasItsRetainedSamples) {
  one_.post(job(7));
  one_.hold();
  one_.hold();
  EXPECT_EQ(take_all(one_), Numbers{});
  EXPECT_TRUE(one_.release(all_retained({1, 2})));
  EXPECT_EQ(take_all(one_), (Numbers{1, 2}));
  EXPECT_FALSE(one_.idle());
  EXPECT_TRUE(one_.release({}));
  EXPECT_EQ(take_all(one_), Numbers{7});
  EXPECT_TRUE(one_.idle());
}

TEST_F(LaneTest, IsIdleAfterAHoldForWhichNothingWasRetained) {
  one_.hold();
  EXPECT_FALSE(one_.release({}));
  EXPECT_TRUE(one_.idle());
}

TEST_F(LaneTest, OwesNothingAnyMoreWhenItIsClosed) {
  one_.hold();
  EXPECT_TRUE(one_.release(all_retained({1, 2, 3})));
  one_.next();
  one_.hold();
  one_.close();
  EXPECT_FALSE(one_.release(all_retained({4})));
  EXPECT_EQ(tally_->history_waiting, 1U) << "what is being sent";
  EXPECT_EQ(take_all(one_), Numbers{});
  EXPECT_EQ(tally_->history_waiting, 0U);
  EXPECT_EQ(held(), 0U);
}

TEST_F(LaneTest, UsesJobsAgain) {
  const Job* first = &*job(1);
  EXPECT_EQ(&*job(2), first);
  EXPECT_EQ(job(3)->first.label.sequence, 3U);
}

}  // namespace
}  // namespace sft::udp
