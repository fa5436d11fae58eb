// Sends the sample that is being published to one destination reliably: a channel keeps the sample until it
// is acknowledged.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <memory>

#include "udp_transport/reliable/channel.h"
#include "udp_transport/reliable/lane.h"
#include "udp_transport/send/best_effort_delivery.h"
#include "udp_transport/send/direct_path.h"
#include "udp_transport/send/draft.h"
#include "udp_transport/send/send_side.h"

namespace sft::udp {

class ReliableDelivery {
 public:
  /// `draft`, `direct` and `best_effort` must outlive this object. If `waits_for_readers` is true, the
  /// publisher may have to wait until readers have acknowledged samples.
  ReliableDelivery(std::shared_ptr<SendSide> side, Draft& draft, DirectPath& direct,
                   BestEffortDelivery& best_effort, bool waits_for_readers)
      : side_(std::move(side)),
        draft_(draft),
        direct_(direct),
        best_effort_(best_effort),
        waits_for_readers_(waits_for_readers) {}

  /// Sends the sample of the draft. Returns the number of older samples that were given up for it.
  std::size_t send(const std::shared_ptr<Lane>& lane, const std::shared_ptr<Channel>& channel);
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

 private:
  std::size_t send_after_history(const std::shared_ptr<Lane>& lane);

  const std::shared_ptr<SendSide> side_;
  Draft& draft_;
  DirectPath& direct_;
  BestEffortDelivery& best_effort_;
  const bool waits_for_readers_;
  std::chrono::nanoseconds timeout_{0};
};

}  // namespace sft::udp
