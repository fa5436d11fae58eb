// The jobs that wait in a lane: first the retained samples for a late reader, then the posted jobs, each in
// the order of publishing. Uses no clock, thread or I/O.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "udp_transport/outgoing/job.h"
#include "udp_transport/reliable/ordinal_ring.h"

namespace sft::udp {

class LaneQueue {
 public:
  /// The limits of posted jobs while more than `depth` jobs may wait.
  struct Limits {
    std::size_t jobs = 0;
    std::size_t bytes = 0;  ///< the maximum memory that the jobs hold, in bytes
  };

  LaneQueue(std::size_t depth, const Limits& beyond_depth);

  /// Returns true if fewer than `depth` posted jobs wait.
  bool has_room() const { return posted_.size() < depth_; }
  /// Returns true if the job can be added within the limits `beyond_depth`.
  bool has_room_beyond_depth(const Job& job) const {
    return posted_.size() < beyond_depth_.jobs && bytes_with(job) <= beyond_depth_.bytes;
  }
  /// Returns the size in bytes of the memory that the posted jobs and `job` hold together. Retained samples
  /// do not count.
  std::size_t bytes_with(const Job& job) const { return posted_bytes_ + job.held_bytes_in_all(); }
  bool empty() const { return posted_.empty() && retained_.empty(); }

  /// Adds the job. The queue accepts every job, so callers must check its limits before.
  void post(JobHandle job);
  /// Takes the oldest posted job. REQUIRES: a posted job waits.
  JobHandle pop_oldest();
  /// Inserts the retained samples before all posted jobs.
  void put_first(std::vector<JobHandle> retained);

  struct Next {
    JobHandle job{};  ///< the job to send; null: no job waits
    bool is_retained = false;
  };
  /// Takes the job that is to be sent next.
  Next take();

  /// Writes the sequence of the lane's first sample into a job for a late reader that is sent without being
  /// queued.
  void mark(Job& job);

  struct Contents {
    OrdinalRing<JobHandle> posted{0};
    std::vector<JobHandle> retained{};
  };
  /// Removes and returns all jobs.
  Contents clear();

 private:
  const std::size_t depth_;
  const Limits beyond_depth_;
  std::vector<JobHandle> retained_;   ///< retained samples in reverse order: the newest is first
  OrdinalRing<JobHandle> posted_{0};  ///< posted jobs in order: the oldest is first
  std::size_t posted_bytes_ = 0;
  std::uint64_t first_sequence_ = 0;  ///< sequence of the lane's first sample; 0: no sample yet
};

}  // namespace sft::udp
