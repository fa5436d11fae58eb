#include "core/negotiation/local_host.h"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace sft::core {

namespace {

/// The quality of an address; smaller values are better.
enum class Rank : std::uint8_t { near_by_wire, near_by_radio, routed, link_local, without_carrier, no_way };

std::pair<Rank, UdpAddress> rank(const UdpAddress& address, std::span<const Link> ours) {
  const bool link_local = address.ip.is_link_local();
  const bool routed = !link_local && std::ranges::any_of(ours, [&](const Link& link) {
    return link.running && !link.ip.is_link_local() && link.ip.is_ipv4() == address.ip.is_ipv4();
  });
  std::pair best{routed ? Rank::routed : Rank::no_way, address};
  bool near = false;
  for (const Link& link : ours) {
    if (link.ip.bytes == address.ip.bytes) return {Rank::no_way, address};
    if (!in_one_network(link.ip, address.ip, link.prefix_bits)) continue;
    const Rank by_it = !link.running                       ? Rank::without_carrier
                       : link_local                        ? Rank::link_local
                       : link.wireless || address.wireless ? Rank::near_by_radio
                                                           : Rank::near_by_wire;
    if (!near || by_it < best.first) {
      best.first = by_it;
      best.second.ip.scope = link.ip.scope;
    }
    near = true;
  }
  return best;
}

}  // namespace

UdpAddress choose_address(std::span<const UdpAddress> of_reader, std::span<const Link> ours) {
  auto best = rank(of_reader.front(), ours);
  for (const UdpAddress& address : of_reader.subspan(1)) {
    if (auto other = rank(address, ours); other.first < best.first) best = std::move(other);
  }
  return best.second;
}

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
