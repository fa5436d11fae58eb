// These tests check the pool of jobs. A job that returns to the pool keeps its memory, which may be used for
// any mask next. They also check the limits of borrowed memory.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "core/seam/buffer_pool.h"
#include "tests/unit/udp/messages.h"
#include "udp_transport/outgoing/job.h"

namespace sft::udp {
namespace {

using Memory = detail::Projection::Memory;

constexpr Memory wide{.staging_bytes = 5000, .segments = 9};

/// Reserves as much memory in the job as a large mask needs.
void widen(const JobHandle& job, const Memory& memory = wide) { job->projection.reserve(memory); }

bool is_wide(const JobHandle& job) { return job->projection.memory().suffices_for(wide); }

TEST(JobPoolTest, SpareJobsGrowAsSoonAsOneComesBackWithMore) {
  const auto jobs = JobPool::make();
  std::vector<JobHandle> spare{jobs->take(), jobs->take(), jobs->take()};
  JobHandle other = jobs->take();
  spare.clear();
  widen(other);
  other = {};
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(is_wide(spare.emplace_back(jobs->take()))) << i;
}

TEST(JobPoolTest, AJobThatWasOutGrowsWhenItComesBack) {
  const auto jobs = JobPool::make();
  JobHandle out = jobs->take(), other = jobs->take();
  widen(other);
  other = {};
  EXPECT_FALSE(is_wide(out)) << "its projection may be in use";
  out = {};
  const JobHandle one = jobs->take(), another = jobs->take();
  EXPECT_TRUE(is_wide(one));
  EXPECT_TRUE(is_wide(another));
}

TEST(JobPoolTest, ANewJobHasAsMuchRoomAsTheOthers) {
  const auto jobs = JobPool::make();
  JobHandle first = jobs->take();
  widen(first);
  first = {};
  const JobHandle again = jobs->take(), added = jobs->take();
  EXPECT_TRUE(is_wide(added));
}

TEST(JobPoolTest, OneHugeSampleDoesNotMakeAllJobsHuge) {
  constexpr std::size_t huge = std::size_t{12} << 20;
  const auto jobs = JobPool::make();
  JobHandle one = jobs->take(), other = jobs->take();
  widen(other, {.staging_bytes = huge});
  one = {};
  other = {};
  const JobHandle last = jobs->take(), first = jobs->take(), added = jobs->take();
  EXPECT_GE(last->projection.memory().staging_bytes, huge) << "it is needed again, perhaps";
  EXPECT_LT(first->projection.memory().staging_bytes, huge);
  EXPECT_LT(added->projection.memory().staging_bytes, huge);
}

/// A pool that had a peak of 10 jobs in one period, and then needs 3 jobs in each period. Their memory is so
/// large that other jobs do not get as much.
class JobPoolAfterAPeak : public testing::Test {
 protected:
  JobPoolAfterAPeak() {
    use(10);
    jobs_->give_back(now_ += period);
    use(3);
  }
  void use(std::size_t count) const {
    std::vector<JobHandle> taken(count);
    for (JobHandle& job : taken) widen(job = jobs_->take(), large);
  }
  /// Returns how many of the jobs are kept. Call it last, because it uses new jobs as well.
  std::ptrdiff_t kept() const {
    std::vector<JobHandle> taken(20);
    for (JobHandle& job : taken) job = jobs_->take();
    return std::ranges::count_if(
        taken, [](const JobHandle& job) { return job->projection.memory().suffices_for(large); });
  }

  static constexpr Memory large{.staging_bytes = std::size_t{3} << 19};
  static constexpr auto period = core::BufferPool::period;
  const std::shared_ptr<JobPool> jobs_ = JobPool::make();
  core::Time now_{};
};

TEST_F(JobPoolAfterAPeak, KeepsItsJobsUntilTheNextPeriodIsOver) {
  jobs_->give_back(now_ + period - std::chrono::milliseconds(1));
  EXPECT_EQ(kept(), 10);
}

TEST_F(JobPoolAfterAPeak, KeepsOnlyTheJobsThatAreNeeded) {
  for (int i = 0; i < 3; ++i) {
    jobs_->give_back(now_ += period);
    use(3);
  }
  EXPECT_EQ(kept(), 3);
}

TEST_F(JobPoolAfterAPeak, KeepsNoJobOnceNobodySends) {
  for (int i = 0; i < 2; ++i) jobs_->give_back(now_ += period);
  EXPECT_EQ(kept(), 0);
}

TEST(BorrowedMemory, IsHeldOfAFewSamplesOnly) {
  const auto jobs = JobPool::make();
  const auto memory = core::BufferPool::make(std::size_t{256} << 20);
  std::vector<JobHandle> held;
  const auto borrow = [&](std::size_t bytes) {
    if (!jobs->may_borrow(bytes)) return false;
    held.push_back(jobs->take());
    held.back()->sample = memory->take(bytes);
    held.back()->borrow();
    return true;
  };
  for (int i = 0; i < 8; ++i) EXPECT_TRUE(borrow(100'000));
  EXPECT_FALSE(borrow(100'000));
  held.clear();
  EXPECT_TRUE(borrow(std::size_t{30} << 20)) << "one, however large";
  EXPECT_FALSE(borrow(100'000));
  for (int round = 0; round < 100; ++round) {
    held.clear();
    for (int i = 0; i < 5; ++i)
      ASSERT_TRUE(borrow(std::size_t{3} << 20)) << "memory that came back can be borrowed again";
  }
}

TEST(BorrowedMemory, IsNotNeededForACopy) {
  const auto pool = core::BufferPool::make(std::size_t{1} << 20);
  const JobHandle job = JobPool::make()->take();
  const FieldMask all = test::fields<test::Image>("*");
  const test::Image image = test::make_image(30'000);
  core::SampleHandle sample = pool->take(test::sample_bytes(image, all));
  test::fill(*sample, image, all, 7, 1);
  const TypeSupport& type = test::type_support<test::Image>();
  job->projection.project(core::state_of(*sample, type.index_slots()), type.type(), all);
  job->mask = std::make_shared<WireMask>();
  const std::size_t bytes = job->projection.bytes();
  job->copy_body(pool->take(bytes));
  std::fill_n(sample->data, sample->capacity, std::byte{0});
  const auto body = job->body().segments;
  ASSERT_EQ(body.size(), 1U);
  const std::span<const std::byte> copied(body[0].data, body[0].bytes);
  EXPECT_TRUE(std::ranges::equal(copied, test::encoded_body(image, all)));
}

}  // namespace
}  // namespace sft::udp
