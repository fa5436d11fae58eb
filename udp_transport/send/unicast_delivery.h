// Sends the sample that is being published to each destination separately: reliably if a reader at the
// destination requests that.
#pragma once

#include <cstddef>
#include <memory>

#include "udp_transport/routing/routes.h"
#include "udp_transport/send/best_effort_delivery.h"
#include "udp_transport/send/reliable_delivery.h"

namespace sft::udp {

struct UnicastDelivery {
  UnicastDelivery(const std::shared_ptr<SendSide>& side, Draft& draft, DirectPath& direct,
                  bool waits_for_readers)
      : best_effort(side, draft, direct), reliable(side, draft, direct, best_effort, waits_for_readers) {}

  /// Sends to the destination of the lane with the index `lane`. Returns the number of samples that are not
  /// sent there.
  std::size_t send(const Audience& audience, std::size_t lane, const core::SampleHandle& sample) {
    const std::shared_ptr<Channel>& channel = audience.channels[lane];
    return channel != nullptr ? reliable.send(audience.lanes[lane], channel)
                              : best_effort.send(audience.lanes[lane], sample);
  }

  BestEffortDelivery best_effort;
  ReliableDelivery reliable;
};

}  // namespace sft::udp
