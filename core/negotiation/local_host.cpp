#include "core/negotiation/local_host.h"

#include <algorithm>

#include "core/negotiation/address_choice.h"

namespace sft::core {

bool LocalHost::self_changed(const Self& self) {
  if (self == self_) return false;
  self_ = self;
  return true;
}

void LocalHost::network_changed(const std::vector<UdpAddress>& addresses, const std::vector<Link>& links) {
  addresses_ = addresses;
  links_ = links;
}

/// A writer that must not write to the shared memory gets no token, so that no reader waits for samples of
/// the writer in shared memory.
void LocalHost::equip(Endpoint& ours) const {
  ours.host = ours.role == Role::writer && !self_.may_write_memory ? HostToken{} : self_.host;
  ours.memory_failure = ours.may_use_memory ? self_.memory_failure : "";
  ours.network = self_.network;
  if (ours.may_use_network && addresses_) ours.addresses = *addresses_;
}

UdpAddress LocalHost::address_of(const Endpoint& reader) const {
  UdpAddress address;
  if (reader.network != self_.network) {
    address = choose_address(reader.addresses, links_);
  } else {  // both nodes use the same network stack, so datagrams never leave the machine
    address = reader.addresses.front();
    const bool has_ipv4 = std::ranges::any_of(reader.addresses, [](const auto& a) { return a.ip.is_ipv4(); });
    address.ip = has_ipv4 ? loopback_ipv4 : loopback_ipv6;
  }
  address.node = reader.node_id;
  return address;
}

}  // namespace sft::core
