// The job of the sample that is being published, until it is given to a lane or a channel.
#pragma once

#include <memory>
#include <utility>

#include "core/seam/buffer_pool.h"
#include "udp_transport/outgoing/job.h"

namespace sft::udp {

/// An object must be used by only one thread.
class Draft {
 public:
  explicit Draft(std::shared_ptr<JobPool> jobs) : jobs_(std::move(jobs)) {}

  /// Returns the job for the next sample.
  Job& begin() {
    if (!handle_) handle_ = jobs_->take();
    return *handle_;
  }
  Job& job() const { return *handle_; }
  const JobHandle& handle() const { return handle_; }

  /// Makes the job keep the sample, so that it can be sent later. Does nothing for a pack, or for a job that
  /// a channel keeps with a copy of the body.
  void keep(const core::SampleHandle& sample) {
    if (!handle_->sample && !is_kept_) handle_->sample = sample;
    is_kept_ = is_kept_ || handle_->is_pack();
  }
  /// Copies the body of a small job. Called before a channel keeps the job. The body of a pack is a copy
  /// already.
  void copy_for_channel() {
    if (!std::exchange(is_kept_, true) && !handle_->is_pack()) handle_->copy_body();
  }
  /// Prepares a large job for channels. Channels keep only a limited number of samples in borrowed memory,
  /// so that this memory suffices for other readers. The number suffices if readers keep up. Further samples
  /// are copied into `pool`, which may be null.
  void keep_in_channels(const core::SampleHandle& sample, const std::shared_ptr<core::BufferPool>& pool);

  /// Must be called after the sample has been sent to the whole audience. The job is used again unless a
  /// lane or a channel has it.
  void release() {
    if (std::exchange(is_kept_, false) || handle_->sample) handle_ = {};
  }
  /// Releases the job, even if it could be used again.
  void reset() {
    handle_ = {};
    is_kept_ = false;
  }
  JobHandle exchange(JobHandle other) { return std::exchange(handle_, std::move(other)); }

 private:
  const std::shared_ptr<JobPool> jobs_;
  JobHandle handle_;
  bool is_kept_ = false;  ///< true if a channel keeps the job
};

}  // namespace sft::udp
