// The host of this node: what our endpoints announce about the host, and the address by which it reaches
// each reader of another node. Uses no clock, thread or I/O.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/control/control.h"
#include "core/negotiation/pair.h"
#include "core/seam/transport.h"

namespace sft::core {

class LocalHost {
 public:
  const Self& self() const { return self_; }
  /// Returns true if anything has changed. Then equip() has to be called for our endpoints again.
  bool self_changed(const Self& self);
  /// Sets the addresses at which our endpoints are reached, and the links by which other nodes are reached.
  /// Then equip() has to be called for our endpoints again.
  void network_changed(const std::vector<UdpAddress>& addresses, const std::vector<Link>& links);

  /// Sets the token, the network and the addresses of one of our endpoints to those that are valid now.
  void equip(Endpoint& ours) const;
  /// Returns the address to which samples for that reader are sent. REQUIRES: the reader has at least one
  /// address.
  UdpAddress address_of(const Endpoint& reader) const;

 private:
  Self self_;
  std::optional<std::vector<UdpAddress>> addresses_;  ///< empty until network_changed() was called
  std::vector<Link> links_;
};

/// Returns the first of the best addresses. The best ones are in a network to which this host is also
/// connected, by an interface with a carrier; wired interfaces at both ends are better than wireless ones.
/// Next come addresses that may be reached by routes, of an address family that this host has. Then come
/// link-local addresses, which seem to be near on every host; their scope becomes that of an interface of
/// this host. Last come addresses of interfaces without a carrier, and addresses that this host has as
/// well. Datagrams to an address of this host would not leave the host (bridges of containers have the same
/// addresses on all hosts). REQUIRES: `of_reader` is not empty.
UdpAddress choose_address(std::span<const UdpAddress> of_reader, std::span<const Link> ours);

}  // namespace sft::core
