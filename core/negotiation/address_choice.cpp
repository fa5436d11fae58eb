#include "core/negotiation/address_choice.h"

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

}  // namespace sft::core
