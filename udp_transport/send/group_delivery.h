// Sends the sample that is being published to a multicast group, and separately to the members that do not
// receive the group.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "udp_transport/routing/routes.h"
#include "udp_transport/send/sample_encoder.h"
#include "udp_transport/send/send_side.h"
#include "udp_transport/send/unicast_delivery.h"

namespace sft::udp {

class GroupDelivery {
 public:
  /// `encoder` and `unicast` must outlive this object.
  GroupDelivery(std::shared_ptr<SendSide> side, const SampleEncoder& encoder, UnicastDelivery& unicast)
      : side_(std::move(side)), encoder_(encoder), unicast_(unicast) {}

  /// REQUIRES: the audience has a multicast group. `body` has the bytes of the job's body: it is the sample
  /// itself, or memory with the requested parts of the sample. Returns the number of destinations that do
  /// not get the sample.
  std::size_t send(const Audience& audience, const core::SampleHandle& sample,
                   const core::SampleHandle& body);

 private:
  void await_room(const Audience& audience);
  std::size_t send_to_others(const Audience& audience, const core::SampleHandle& sample, bool goes_to_group);
  std::size_t keep_for(const Audience& audience, std::size_t member, std::uint64_t ordinal, bool has_room);
  bool send_to_group(const Audience& audience, const core::SampleHandle& body);

  const std::shared_ptr<SendSide> side_;
  const SampleEncoder& encoder_;
  UnicastDelivery& unicast_;
};

}  // namespace sft::udp
