// The job of the present sample, until it is given to a lane or a channel.
#pragma once

#include <memory>
#include <utility>

#include "core/seam/buffer_pool.h"
#include "udp_transport/outgoing/job.h"

namespace sft::udp {

/// An object is used by one thread only.
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

  /// Makes the job keep the sample, because the job is sent later. If a channel has the job, the job holds
  /// a copy of the body instead. A pack has no sample, since it holds copies.
  void keep(const core::SampleHandle& sample) {
    if (!handle_->sample && !is_kept_) handle_->sample = sample;
    is_kept_ = is_kept_ || handle_->is_pack();
  }
  /// Copies the body of a small job that a channel will keep. The body of a pack is a copy already.
  void copy_for_channel() {
    if (!std::exchange(is_kept_, true) && !handle_->is_pack()) handle_->copy_body();
  }
  /// Prepares a large job for channels. They keep samples in borrowed memory only in the number that is
  /// needed while readers keep up, so that enough of this memory is left to other readers. Further samples
  /// are copied into `pool`, which may be null.
  void keep_in_channels(const core::SampleHandle& sample, const std::shared_ptr<core::BufferPool>& pool);

  /// Ends the sample, after it has been sent to the whole audience. The job is used again unless a lane or
  /// a channel has it.
  void release() {
    if (std::exchange(is_kept_, false) || handle_->sample) handle_ = {};
  }
  /// Gives up the job, even if it could be used again.
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
