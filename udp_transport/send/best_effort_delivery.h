// Sends the sample that is being published to one destination by best effort: at once, or through a lane.
#pragma once

#include <cstddef>
#include <memory>

#include "udp_transport/reliable/lane.h"
#include "udp_transport/send/direct_path.h"
#include "udp_transport/send/draft.h"
#include "udp_transport/send/send_side.h"

namespace sft::udp {

class BestEffortDelivery {
 public:
  /// `draft` and `direct` must outlive this object.
  BestEffortDelivery(std::shared_ptr<SendSide> side, Draft& draft, DirectPath& direct)
      : side_(std::move(side)), draft_(draft), direct_(direct) {}

  /// Sends the sample of the draft. Returns the number of samples that are not sent to the destination: the
  /// new ones, or older ones that were dropped for them.
  std::size_t send(const std::shared_ptr<Lane>& lane, const core::SampleHandle& sample);
  /// Queues the job of the draft in the lane. Returns 1 if older jobs were dropped for it, else 0.
  std::size_t enqueue(const std::shared_ptr<Lane>& lane);

 private:
  const std::shared_ptr<SendSide> side_;
  Draft& draft_;
  DirectPath& direct_;
};

}  // namespace sft::udp
