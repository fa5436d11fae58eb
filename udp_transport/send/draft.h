// The job of the present sample, until a lane or a channel has it.
#pragma once

#include <memory>
#include <utility>

#include "core/seam/buffer_pool.h"
#include "udp_transport/outgoing/job.h"

namespace sft::udp {

/// Used by one thread.
class Draft {
 public:
  explicit Draft(std::shared_ptr<JobPool> jobs) : jobs_(std::move(jobs)) {}

  /// A job for the next sample.
  Job& begin() {
    if (!handle_) handle_ = jobs_->take();
    return *handle_;
  }
  Job& job() const { return *handle_; }
  const JobHandle& handle() const { return handle_; }

  /// The job is sent later, and keeps the sample until then. Where a channel has the job, it holds a copy of
  /// the body instead, and counts what it holds. A pack has no sample: it keeps all by itself.
  void keep(const core::SampleHandle& sample) {
    if (!handle_->sample && !is_kept_) handle_->sample = sample;
    is_kept_ = is_kept_ || handle_->is_pack();
  }
  /// A channel keeps the small job, with a copy of the body. The body of a pack is a copy already.
  void copy_for_channel() {
    if (!std::exchange(is_kept_, true) && !handle_->is_pack()) handle_->copy_body();
  }
  /// Channels keep the large job. Of samples in borrowed memory, as many may be held there as are needed
  /// while readers keep up, since other readers of that memory must not miss any. The others are copied into
  /// `pool`, which may be null.
  void keep_in_channels(const core::SampleHandle& sample, const std::shared_ptr<core::BufferPool>& pool);

  /// The sample has been sent to the whole audience. The job is used again unless somebody has it.
  void release() {
    if (std::exchange(is_kept_, false) || handle_->sample) handle_ = {};
  }
  /// Gives the job up, whatever it is.
  void reset() {
    handle_ = {};
    is_kept_ = false;
  }
  JobHandle exchange(JobHandle other) { return std::exchange(handle_, std::move(other)); }

 private:
  const std::shared_ptr<JobPool> jobs_;
  JobHandle handle_;
  bool is_kept_ = false;  ///< by a channel
};

}  // namespace sft::udp
