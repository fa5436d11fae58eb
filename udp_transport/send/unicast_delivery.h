// Sends the sample that is being published to each destination separately: by best effort, at once or through
// a lane; or reliably, if a reader at the destination requests that. A channel then keeps the sample until it
// is acknowledged.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <memory>
#include <utility>

#include "core/seam/buffer_pool.h"
#include "udp_transport/outgoing/job.h"
#include "udp_transport/reliable/channel.h"
#include "udp_transport/reliable/lane.h"
#include "udp_transport/routing/routes.h"
#include "udp_transport/send/direct_path.h"
#include "udp_transport/send/send_side.h"

namespace sft::udp {

/// Has the job of the sample until it is given to a lane or a channel. An object must be used by only one
/// thread.
class UnicastDelivery {
 public:
  /// If `waits_for_readers` is true, the publisher may have to wait until readers have acknowledged samples.
  UnicastDelivery(std::shared_ptr<SendSide> side, std::shared_ptr<WriterTally> tally,
                  std::shared_ptr<JobPool> jobs, bool waits_for_readers)
      : direct(side, std::move(tally)),
        side_(std::move(side)),
        jobs_(std::move(jobs)),
        waits_for_readers_(waits_for_readers) {}

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
  /// Prepares the job for the channels of the audience, if there are any. Copies the body of a small job; the
  /// body of a pack is a copy already. Channels keep only a limited number of large samples in borrowed
  /// memory, so that this memory suffices for other readers. The number suffices if readers keep up. Further
  /// samples are copied into the pool of the sending side, which may be null.
  void prepare_for_channels(const Audience& audience, const core::SampleHandle& sample);
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

  /// REQUIRES: prepare_for_channels() was called, if the lane has a channel. Sends the job to the destination
  /// of the lane with the index `lane`. Returns the number of samples that are not sent there: the new ones,
  /// or older ones that were dropped or given up for them.
  std::size_t send(const Audience& audience, std::size_t lane, const core::SampleHandle& sample) {
    const std::shared_ptr<Channel>& channel = audience.channels[lane];
    return channel != nullptr ? send_reliably(audience.lanes[lane], channel)
                              : send_once(audience.lanes[lane], sample);
  }
  /// Queues the job in the lane. Returns 1 if older jobs were dropped for it, else 0.
  std::size_t enqueue(const std::shared_ptr<Lane>& lane);
  /// Wakes the sending thread if the channel needs it, and counts the lost samples. Returns the number of
  /// older samples that were given up for the posted job, but at most the number of samples in that job.
  std::size_t settle(const Channel::Posted& posted, const std::shared_ptr<Channel>& channel, Lane& lane,
                     std::size_t job_samples);

  /// Sets the total time that the publisher may wait for acks, so that no older sample has to be given up
  /// for a new one.
  void set_timeout(std::chrono::nanoseconds timeout) { timeout_ = timeout; }
  void cap_timeout(std::chrono::nanoseconds timeout) { timeout_ = std::min(timeout_, timeout); }
  /// Returns the rest of that time; null if the publisher must not wait. A caller that waits must subtract
  /// the time of waiting from it.
  std::chrono::nanoseconds* timeout() { return timeout_.count() == 0 ? nullptr : &timeout_; }

  DirectPath direct;

 private:
  std::size_t send_once(const std::shared_ptr<Lane>& lane, const core::SampleHandle& sample);
  std::size_t send_reliably(const std::shared_ptr<Lane>& lane, const std::shared_ptr<Channel>& channel);

  const std::shared_ptr<SendSide> side_;
  const std::shared_ptr<JobPool> jobs_;
  JobHandle handle_;
  bool is_kept_ = false;  ///< true if a channel keeps the job
  const bool waits_for_readers_;
  std::chrono::nanoseconds timeout_{0};
};

}  // namespace sft::udp
