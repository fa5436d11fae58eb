// The jobs that wait in a lane: first the retained samples for a late reader, then what was posted, the
// oldest first. Pure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "udp_transport/outgoing/job.h"
#include "udp_transport/reliable/ordinal_ring.h"

namespace sft::udp {

class LaneQueue {
 public:
  /// Limits of what was posted, where more than `depth` may wait.
  struct Limits {
    std::size_t jobs = 0;
    std::size_t bytes = 0;  ///< memory that the jobs hold
  };

  LaneQueue(std::size_t depth, const Limits& beyond_depth);

  /// True if fewer jobs than `depth` were posted.
  bool has_room() const { return posted_.size() < depth_; }
  /// True if the job is within the limits beyond the depth.
  bool has_room_beyond_depth(const Job& job) const {
    return posted_.size() < beyond_depth_.jobs && bytes_with(job) <= beyond_depth_.bytes;
  }
  /// Memory that is held once the job is posted, too. Retained samples do not count.
  std::size_t bytes_with(const Job& job) const { return posted_bytes_ + job.held_bytes_in_all(); }
  bool empty() const { return posted_.empty() && retained_.empty(); }

  /// Callers look for room before; the queue takes every job.
  void post(JobHandle job);
  /// Takes out what was posted first. REQUIRES: a posted job waits.
  JobHandle pop_oldest();
  /// These samples go before all that was posted.
  void put_first(std::vector<JobHandle> retained);

  struct Next {
    JobHandle job{};  ///< null: nothing waits
    bool is_retained = false;
  };
  /// Takes out the job that is sent next.
  Next take();

  /// Notes the first sequence of the lane in a job for a late reader that is sent without being queued.
  void mark(Job& job);

  struct Contents {
    OrdinalRing<JobHandle> posted{0};
    std::vector<JobHandle> retained{};
  };
  /// Takes out everything.
  Contents clear();

 private:
  const std::size_t depth_;
  const Limits beyond_depth_;
  std::vector<JobHandle> retained_;   ///< the newest first
  OrdinalRing<JobHandle> posted_{0};  ///< the oldest first
  std::size_t posted_bytes_ = 0;
  std::uint64_t first_sequence_ = 0;  ///< of the lane's first sample; 0: there was none
};

}  // namespace sft::udp
