// Sends a large sample directly from the program's memory. Only the rest that cannot be sent at once is
// copied.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "udp_transport/routing/routes.h"
#include "udp_transport/send/unicast_delivery.h"

namespace sft::udp {

class PostponedDelivery {
 public:
  /// `unicast` must outlive this object.
  explicit PostponedDelivery(UnicastDelivery& unicast) : unicast_(unicast) {}

  /// Returns true if no older sample has to be sent first, and there is a connection for large samples.
  static bool is_possible(const Audience& audience);
  /// Sends to the only destination of the audience. Returns the number of samples that are not sent to the
  /// destination. Returns nothing, and has sent no data, if another sample has to be sent first.
  std::optional<std::size_t> send(const Audience& audience, const core::SampleHandle& sample);

 private:
  std::size_t send_once(const std::shared_ptr<Lane>& lane, const core::SampleHandle& sample);
  std::optional<std::size_t> send_reliably(Lane& lane, const std::shared_ptr<Channel>& channel,
                                           const core::SampleHandle& sample);
  std::uint32_t send_located(const FirstHeader& first, Destination& to) {
    return unicast_.direct.send_some({first, unicast_.job().mask->words, located_}, to);
  }

  UnicastDelivery& unicast_;
  std::vector<detail::Segment> located_;  ///< segments of the sample's body in the program's memory
};

}  // namespace sft::udp
