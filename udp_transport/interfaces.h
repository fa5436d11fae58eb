// What the host's network looks like: its own IPv4 addresses, and how long a datagram for an address may be.
#pragma once

#include <netinet/in.h>

#include <cstdint>
#include <string>
#include <vector>

#include "core/transport.h"
#include "udp_transport/datagram_io.h"

namespace sft::udp {

sockaddr_in to_sockaddr(const SocketAddress& address) noexcept;
SocketAddress to_address(const sockaddr_in& address) noexcept;
std::string format_ipv4(std::uint32_t ipv4);

/// Of the interfaces that are up: that of the default route first, those without carrier last; 127.0.0.1 only
/// where there is no other. If `chosen` is not empty, of these interfaces only, each given by its name, an
/// address of it, or the address of its network.
std::vector<core::Link> own_links(const std::vector<std::string>& chosen = {});

/// Bytes of the longest UDP payload that reaches the address in one piece, as far as the kernel knows by now.
std::uint16_t datagram_bytes_to(const SocketAddress& address) noexcept;

}  // namespace sft::udp
