// Sends the present sample to one destination by best effort: at once, or through its lane.
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
  /// The draft and the direct path must outlive this object.
  BestEffortDelivery(std::shared_ptr<SendSide> side, Draft& draft, DirectPath& direct)
      : side_(std::move(side)), draft_(draft), direct_(direct) {}

  /// Returns the number of samples that do not get to the destination: the present ones, or older ones that
  /// were given up.
  std::size_t send(const std::shared_ptr<Lane>& lane, const core::SampleHandle& sample);
  /// Queues the job in the lane. Returns 1 if older jobs were given up for it.
  std::size_t enqueue(const std::shared_ptr<Lane>& lane);

 private:
  const std::shared_ptr<SendSide> side_;
  Draft& draft_;
  DirectPath& direct_;
};

}  // namespace sft::udp
