#include "core/address_choice.h"

#include <algorithm>

namespace sft::core {

const UdpAddress& choose_address(std::span<const UdpAddress> of_reader, std::span<const Link> ours) {
  const auto is_ours = [&](const UdpAddress& address) {
    return std::ranges::any_of(ours, [&](const Link& link) { return link.ipv4 == address.ipv4; });
  };
  const auto is_near = [&](const UdpAddress& address) {
    return !is_ours(address) && std::ranges::any_of(ours, [&](const Link& link) {
      return ((link.ipv4 ^ address.ipv4) & link.netmask) == 0;
    });
  };
  if (const auto near = std::ranges::find_if(of_reader, is_near); near != of_reader.end()) return *near;
  const auto other = std::ranges::find_if_not(of_reader, is_ours);
  return other != of_reader.end() ? *other : of_reader.front();
}

}  // namespace sft::core
