#include "udp_transport/io/answer_address.h"

#include <algorithm>

namespace sft::udp {

namespace {

constexpr std::uint16_t privileged_ports_end = 1024;

bool is_loopback(const core::IpAddress& ip) {
  return ip == core::loopback_ipv6 || (ip.is_ipv4() && ip.ipv4() >> 24 == 127);
}

}  // namespace

bool is_announced(const core::Announced& node, const core::IpAddress& ip) {
  if (!node.known) return true;
  if (is_loopback(ip)) return node.same_network;
  return std::ranges::any_of(node.addresses,
                             [&](const core::UdpAddress& a) { return a.ip.bytes == ip.bytes; });
}

std::optional<SocketAddress> answer_address(const core::Announced& node, const core::IpAddress& from,
                                            std::uint16_t port) {
  if (!node.known) return SocketAddress{from, port};
  const bool port_is_announced = std::ranges::any_of(
      node.addresses, [&](const core::UdpAddress& address) { return address.port == port; });
  if (port < privileged_ports_end && !port_is_announced) return {};
  if (is_announced(node, from)) return SocketAddress{from, port};
  const auto other = std::ranges::find_if(node.addresses, [&](const core::UdpAddress& address) {
    return address.ip.is_ipv4() == from.is_ipv4() && !is_loopback(address.ip);
  });
  if (other == node.addresses.end()) return {};
  return SocketAddress{other->ip, port};
}

}  // namespace sft::udp
