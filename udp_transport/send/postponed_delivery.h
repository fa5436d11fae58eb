// Sends a large sample from the program's memory, before its body is copied.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "udp_transport/routing/routes.h"
#include "udp_transport/send/direct_path.h"
#include "udp_transport/send/draft.h"
#include "udp_transport/send/unicast_delivery.h"

namespace sft::udp {

class PostponedDelivery {
 public:
  /// The draft, the direct path and the unicast delivery must outlive this object.
  PostponedDelivery(Draft& draft, DirectPath& direct, UnicastDelivery& unicast)
      : draft_(draft), direct_(direct), unicast_(unicast) {}

  /// Returns true if no other sample has to be sent before this one, and there is a connection for it.
  static bool is_possible(const Audience& audience);
  /// Sends through the only lane of the audience. Returns the number of samples that do not get to the
  /// destination. Empty if another sample has to be sent first; in that case nothing was sent.
  std::optional<std::size_t> send(const Audience& audience, const core::SampleHandle& sample);

 private:
  std::size_t send_once(const std::shared_ptr<Lane>& lane, const core::SampleHandle& sample);
  std::optional<std::size_t> send_reliably(Lane& lane, const std::shared_ptr<Channel>& channel,
                                           const core::SampleHandle& sample);
  std::uint32_t send_located(const FirstHeader& first, Destination& to) {
    return direct_.send_some({first, draft_.job().mask->words, located_}, to);
  }

  Draft& draft_;
  DirectPath& direct_;
  UnicastDelivery& unicast_;
  std::vector<detail::Segment> located_;  ///< segments of the present body in the program's memory
};

}  // namespace sft::udp
