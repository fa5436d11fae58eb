// What the host's network looks like: its own IPv4 addresses, and how long a datagram for an address may be.
#pragma once

#include <netinet/in.h>

#include <cstdint>
#include <string>
#include <vector>

#include "udp_transport/datagram_io.h"

namespace sft::udp {

sockaddr_in to_sockaddr(const SocketAddress& address) noexcept;
SocketAddress to_address(const sockaddr_in& address) noexcept;
std::string format_ipv4(std::uint32_t ipv4);

/// Addresses of interfaces that are up: that of the default route first, those without carrier last;
/// 127.0.0.1 only where there is no other.
std::vector<std::uint32_t> own_addresses();

/// Bytes of the longest UDP payload that reaches the address in one piece, as far as the kernel knows by now.
std::uint16_t datagram_bytes_to(const SocketAddress& address) noexcept;

}  // namespace sft::udp
