// The memory of jobs that any mask may use next.
#include <gtest/gtest.h>

#include <cstddef>
#include <memory>
#include <vector>

#include "udp_transport/outgoing/job.h"

namespace sft::udp {
namespace {

using Memory = detail::Projection::Memory;

constexpr Memory wide{.staging_bytes = 5000, .segments = 9};

/// As a mask with much to stage leaves it.
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

}  // namespace
}  // namespace sft::udp
