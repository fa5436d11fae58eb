#include "udp_transport/reliable/lane.h"

#include <gtest/gtest.h>

#include <chrono>
#include <future>
#include <span>
#include <thread>
#include <vector>

#include "core/seam/buffer_pool.h"
#include "tests/support/eventually.h"
#include "tests/unit/udp/connections.h"
#include "tests/unit/udp/jobs.h"
#include "udp_transport/flow/destination_directory.h"
#include "udp_transport/reliable/channel.h"

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
    job->sequence = number;
    return job;
  }
  JobHandle for_late_reader(std::uint32_t number) {
    JobHandle one = job(number);
    one->first.flags = history_follows;
    return one;
  }
  std::vector<JobHandle> retained(const Numbers& numbers) {
    std::vector<JobHandle> jobs;
    for (const std::uint32_t number : numbers) jobs.push_back(for_late_reader(number));
    return jobs;
  }
  static Numbers take_all(Lane& lane) {
    Numbers numbers;
    while (const Job* job = lane.next()) numbers.push_back(job->first.label.sequence);
    return numbers;
  }
  /// Returns the number of samples whose memory is in use.
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
  Lane one_{destinations_.find({.ip = 0x7F000001, .port = 1}), 3, tally_};
  Lane late_{destinations_.find({.ip = 0x7F000001, .port = 1}), 3, tally_, Lane::Start::held};
  Lane other_{destinations_.find({.ip = 0x7F000001, .port = 2}), 3, tally_};
};

TEST_F(LaneTest, IsIdleUntilSomethingIsPostedAndOnceAllIsTaken) {
  EXPECT_TRUE(one_.idle());
  EXPECT_EQ(one_.post(job(1)).wake, Wake::schedule);
  EXPECT_EQ(one_.post(job(2)).wake, Wake::none);
  EXPECT_FALSE(one_.idle());
  EXPECT_EQ(take_all(one_), (Numbers{1, 2}));
  EXPECT_TRUE(one_.idle());
}

TEST_F(LaneTest, KeepsTheNewest) {
  for (std::uint32_t n = 1; n <= 3; ++n) EXPECT_EQ(one_.post(job(n)).dropped, 0U);
  EXPECT_EQ(one_.post(job(4)).dropped, 1U);
  EXPECT_EQ(take_all(one_), (Numbers{2, 3, 4}));
}

TEST_F(LaneTest, KeepsABurstOfSmallSamplesForAReceiverThatHasNotReportedYet) {
  DestinationDirectory asking({.report_port = 7}, connections_.connect());
  Lane lane(asking.find({.ip = 0x7F000001, .port = 1}), 3, tally_);
  Numbers posted;
  for (std::uint32_t n = 1; n <= 4096; ++n) {
    EXPECT_EQ(lane.post(test::make_job(*jobs_, n)).dropped, 0U) << n;
    posted.push_back(n + 1);
  }
  EXPECT_EQ(lane.post(test::make_job(*jobs_, 4097)).dropped, 1U);
  EXPECT_EQ(take_all(lane), posted);
}

TEST_F(LaneTest, KeepsThatBurstWhenTheReportCame) {
  DestinationDirectory asking({.report_port = 7}, connections_.connect());
  const auto to = asking.find({.ip = 0x7F000001, .port = 1});
  Lane lane(to, 3, tally_);
  const auto post = [&](std::uint32_t n) { return lane.post(test::make_job(*jobs_, n)).dropped; };
  for (std::uint32_t n = 1; n <= 10; ++n) EXPECT_EQ(post(n), 0U) << n;
  const auto now = std::chrono::steady_clock::now();
  to->sent(to->connection(), 100, 1, 100, now);
  ASSERT_TRUE(to->hear(connections_.answer_to_mark(), core::IpAddress{0x7F000001U}, now).accepted);
  for (std::uint32_t n = 11; n <= 20; ++n) EXPECT_EQ(post(n), 0U) << n;
  EXPECT_EQ(take_all(lane).size(), 20U);
}

TEST_F(LaneTest, KeepsNoBurstIfOnlyLargeSamplesHaveWaitedForTheReport) {
  DestinationDirectory asking({.report_port = 7}, connections_.connect());
  const auto to = asking.find({.ip = 0x7F000001, .port = 1});
  Lane lane(to, 3, tally_);
  lane.post(test::make_job(*jobs_, 1, 2 * direct_bytes_max));
  const auto now = std::chrono::steady_clock::now();
  to->sent(to->connection(), 100, 1, 100, now);
  ASSERT_TRUE(to->hear(connections_.answer_to_mark(), core::IpAddress{0x7F000001U}, now).accepted);
  for (std::uint32_t n = 2; n <= 3; ++n) EXPECT_EQ(lane.post(test::make_job(*jobs_, n)).dropped, 0U);
  EXPECT_EQ(lane.post(test::make_job(*jobs_, 4)).dropped, 1U);
}

TEST_F(LaneTest, SkipsNothingForADestinationThatFallsBehind) {
  for (std::uint32_t n = 1; n <= 6; ++n) {
    const JobHandle shared = job(n);
    EXPECT_EQ(one_.post(shared).dropped, 0U);
    EXPECT_EQ(other_.post(shared).dropped, n > 3 ? 1U : 0U);
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
  EXPECT_EQ(one_.post(job(3)).dropped, 0U);
  EXPECT_EQ(take_all(one_), Numbers{});
  EXPECT_EQ(held(), 0U);
}

TEST_F(LaneTest, SendsRetainedSamplesHoweverManyBeforeWhatWaitedForThem) {
  EXPECT_FALSE(late_.idle());
  EXPECT_EQ(late_.post(job(5)).wake, Wake::none) << "it cannot go yet";
  EXPECT_EQ(late_.begin(retained({1, 2, 3, 4})), Wake::schedule);
  EXPECT_EQ(late_.post(job(6)).wake, Wake::none);
  EXPECT_EQ(take_all(late_), (Numbers{1, 2, 3, 4, 5, 6}));
  EXPECT_TRUE(late_.idle());
}

TEST_F(LaneTest, BeginsOnce) {
  EXPECT_EQ(late_.begin(retained({1, 2, 3})), Wake::schedule);
  EXPECT_EQ(late_.next()->sequence, 1U);
  EXPECT_EQ(late_.begin(retained({1, 2, 3})), Wake::none) << "two would send its samples at a time";
  EXPECT_EQ(take_all(late_), (Numbers{2, 3}));
}

TEST_F(LaneTest, GoesOnWithWhatWaitedWhereNothingIsRetained) {
  late_.post(job(5));
  EXPECT_EQ(late_.begin({}), Wake::schedule);
  EXPECT_EQ(take_all(late_), Numbers{5});
}

TEST_F(LaneTest, IsIdleOnceItHasBegunWithNothing) {
  EXPECT_EQ(late_.begin({}), Wake::none);
  EXPECT_TRUE(late_.idle());
  EXPECT_EQ(late_.post(job(1)).wake, Wake::schedule);
}

TEST_F(LaneTest, SaysThatTheHistoryHasDepartedOnceItIsAcknowledgedAlthoughLaterSamplesAreNot) {
  const auto to = destinations_.find({.ip = 0x7F000001, .port = 1});
  const auto channel = std::make_shared<Channel>(1, 1, to, tally_, 7);
  Lane lane(to, 3, tally_, Lane::Start::held, channel);
  lane.post(test::make_job(*jobs_, 6));
  EXPECT_EQ(lane.begin({test::make_job(*jobs_, 5)}), Wake::schedule);
  while (lane.next() != nullptr)
    lane.passed_on(channel->post(lane.current(), lane.current()->first, false).kept.ordinal);
  EXPECT_FALSE(lane.history_has_departed());
  while (const auto piece = channel->next(ResendWindow::Size::small))
    static_cast<void>(channel->finished(*piece, {}));
  static_cast<void>(channel->hear({.writer = 1, .channel = 1, .next = 2}));
  EXPECT_TRUE(lane.history_has_departed());
}

TEST_F(LaneTest, TellsWithEachSampleWhichWasTheFirst) {
  late_.post(for_late_reader(7));
  EXPECT_EQ(late_.begin(retained({5, 6})), Wake::schedule);
  while (const Job* job = late_.next()) EXPECT_EQ(job->first.history.oldest, 5U) << job->sequence;
  const JobHandle direct = for_late_reader(8);
  late_.mark(*direct);
  EXPECT_EQ(direct->first.history.oldest, 5U);
}

TEST_F(LaneTest, LetsSmallSamplesWaitForTheHistoryBeyondItsDepth) {
  for (std::uint32_t n = 4; n <= 8; ++n) EXPECT_EQ(late_.post(for_late_reader(n)).dropped, 0U);
  EXPECT_EQ(late_.begin(retained({2, 3})), Wake::schedule);
  EXPECT_EQ(take_all(late_), (Numbers{2, 3, 4, 5, 6, 7, 8}));
}

TEST_F(LaneTest, CountsFromTheFirstLiveSampleWhereNothingIsRetainedAlsoIfThatIsDropped) {
  memory_ = core::BufferPool::make(std::size_t{1} << 24);
  const auto large = [&](std::uint32_t number) {
    JobHandle one = for_late_reader(number);
    one->sample = memory_->take(600'000);
    return one;
  };
  EXPECT_EQ(late_.begin({}), Wake::none);
  for (std::uint32_t n = 4; n <= 8; ++n) late_.post(large(n));
  const Job* job = late_.next();
  EXPECT_EQ(job->sequence, 6U);
  EXPECT_EQ(job->first.history.oldest, 4U);
}

TEST_F(LaneTest, SendsNothingAnyMoreWhenItIsClosedBeforeItBegins) {
  late_.post(job(4));
  late_.close();
  EXPECT_EQ(late_.begin(retained({1, 2, 3})), Wake::none);
  EXPECT_EQ(take_all(late_), Numbers{});
  EXPECT_EQ(held(), 0U);
}

TEST_F(LaneTest, WaitsNotAtAllIfThereIsRoomAndForTheTimeoutIfThereIsNone) {
  std::chrono::nanoseconds hang_timeout = std::chrono::milliseconds(1);
  one_.await_room(*job(1), hang_timeout);
  EXPECT_EQ(hang_timeout, std::chrono::milliseconds(1));
  for (std::uint32_t n = 1; n <= 3; ++n) one_.post(job(n));
  one_.await_room(*job(4), hang_timeout);
  EXPECT_EQ(hang_timeout.count(), 0);
}

/// The other thread most likely waits already when next() is called. If it does not wait yet, it can queue
/// its job at once.
TEST_F(LaneTest, WaitsForRoomOnlyUntilAJobIsTaken) {
  for (std::uint32_t n = 1; n <= 3; ++n) one_.post(job(n));
  std::promise<void> begins;
  auto remaining = std::async(std::launch::async, [&, next = job(4)] {
    std::chrono::nanoseconds hang_timeout = std::chrono::hours(1);
    begins.set_value();
    one_.await_room(*next, hang_timeout);
    return hang_timeout;
  });
  begins.get_future().wait();
  for (int turns = 0; turns < 100; ++turns) std::this_thread::yield();
  one_.next();
  EXPECT_GT(remaining.get().count(), 0);
}

TEST_F(LaneTest, UsesJobsAgain) {
  const Job* first = &*job(1);
  EXPECT_EQ(&*job(2), first);
  EXPECT_EQ(job(3)->first.label.sequence, 3U);
}

struct NoGroup final : LaneListener {
  void departed(const Job&, bool) noexcept override {}
  std::span<const Destination* const> receivers() const noexcept override { return {}; }
};

TEST_F(LaneTest, IsClearOnceNoGroupOfItsWriterHasSomethingToSend) {
  const auto group = std::make_shared<NoGroup>();
  other_.end().notify(group);
  EXPECT_TRUE(one_.is_clear());
  other_.post(job(1));
  EXPECT_FALSE(one_.is_clear());
  EXPECT_EQ(take_all(other_), Numbers{1});
  EXPECT_TRUE(one_.is_clear());
  late_.post(job(2));
  EXPECT_TRUE(one_.is_clear()) << "lanes of other readers do not count";
}

TEST_F(LaneTest, IsClearOnceNoLaneThatReadersShareHasSomethingToSend) {
  other_.end().set_shared(true);
  other_.post(job(1));
  EXPECT_FALSE(one_.is_clear());
  other_.end().set_shared(false);
  EXPECT_EQ(take_all(other_), Numbers{1});
  EXPECT_TRUE(one_.is_clear()) << "what has begun to count does not count for ever";
  other_.post(job(2));
  EXPECT_TRUE(one_.is_clear());
}

TEST_F(LaneTest, OfAGroupIsClearOnceNoLaneOfItsWriterHasSomethingToSend) {
  const auto group = std::make_shared<NoGroup>();
  other_.end().notify(group);
  one_.post(job(1));
  EXPECT_FALSE(other_.is_clear());
  EXPECT_EQ(take_all(one_), Numbers{1});
  EXPECT_TRUE(other_.is_clear());
  late_.post(job(2));
  EXPECT_TRUE(other_.is_clear()) << "what is held is not known to the sending thread";
  EXPECT_EQ(late_.begin(retained({1})), Wake::schedule);
  EXPECT_FALSE(other_.is_clear());
  EXPECT_EQ(take_all(late_), (Numbers{1, 2}));
  EXPECT_TRUE(other_.is_clear());
}

/// Records whether other threads can use the lane while departed() is called.
struct Onlooker final : LaneListener {
  explicit Onlooker(Lane& one) : lane(one) {}
  void departed(const Job& job, bool lost) noexcept override {
    lost_ones.push_back(lost ? job.first.label.sequence : 0);
    uses.push_back(std::async(std::launch::async, [this] { return lane.has_room(); }));
    was_free = uses.back().wait_for(sft::test::hang_timeout) == std::future_status::ready && was_free;
  }
  std::span<const Destination* const> receivers() const noexcept override { return {}; }
  Lane& lane;
  std::vector<std::uint32_t> lost_ones;
  bool was_free = true;
  std::vector<std::future<bool>> uses;
};

TEST_F(LaneTest, TellsWhatItLostWithoutKeepingOthersOut) {
  const auto listener = std::make_shared<Onlooker>(one_);
  one_.end().notify(listener);
  for (std::uint32_t n = 1; n <= 4; ++n) one_.post(job(n));
  one_.close();
  one_.post(job(5));
  EXPECT_EQ(listener->lost_ones, (Numbers{1, 2, 3, 4, 5}));
  EXPECT_TRUE(listener->was_free);
}

}  // namespace
}  // namespace sft::udp
