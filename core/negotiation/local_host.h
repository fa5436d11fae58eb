// This node's host: what it gives to our endpoints for their announcements, and by which address it reaches
// the readers of other nodes. Pure.
#pragma once

#include <optional>
#include <vector>

#include "core/control/control.h"
#include "core/negotiation/pair.h"
#include "core/seam/transport.h"

namespace sft::core {

class LocalHost {
 public:
  const Self& self() const { return self_; }
  /// Returns true if anything has changed. Our endpoints have to be equipped again then.
  bool self_changed(const Self& self);
  /// Our endpoints are reached at these addresses from now on, and others over these links. Our endpoints
  /// have to be equipped again.
  void network_changed(const std::vector<UdpAddress>& addresses, const std::vector<Link>& links);

  /// Gives one of our endpoints the token, the network and the addresses that are valid now.
  void equip(Endpoint& ours) const;
  /// Returns the address to which samples for that reader are sent. The reader has at least one address.
  UdpAddress address_of(const Endpoint& reader) const;

 private:
  Self self_;
  std::optional<std::vector<UdpAddress>> addresses_;  ///< once they were told
  std::vector<Link> links_;
};

}  // namespace sft::core
