// Sends a large sample from where the program has it, before its body is copied.
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
  /// The draft, the direct path and the unicast delivery outlive this one.
  PostponedDelivery(Draft& draft, DirectPath& direct, UnicastDelivery& unicast)
      : draft_(draft), direct_(direct), unicast_(unicast) {}

  /// Returns true if nothing has to be sent before the sample, and there is a connection for it.
  static bool is_possible(const Audience& audience);
  /// Sends through the only lane of the audience. Returns how many samples do not get there. Empty if
  /// something else has to be sent first; then nothing was sent.
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
