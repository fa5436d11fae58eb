// The host's network: its own addresses, and the length of the longest datagram to an address.
#pragma once

#include <netinet/in.h>
#include <sys/socket.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/seam/transport.h"
#include "sft/result.h"
#include "udp_transport/io/datagram_io.h"
#include "udp_transport/wire/datagram.h"

namespace sft::udp {

/// An address in the form that system calls take. Its family is that of the socket for which it is used.
class SystemAddress {
 public:
  /// Converts the address, and keeps its family; the address "any" gets `family_of_any`.
  explicit SystemAddress(const SocketAddress& address, int family_of_any = AF_INET) noexcept;
  /// Converts the address for a socket of `family`. A socket of both families (AF_INET6) gets IPv4 addresses
  /// as IPv4-mapped ones. A socket of IPv4 only (AF_INET) refuses IPv6 addresses.
  static SystemAddress for_socket(const SocketAddress& address, int family) noexcept;

  const sockaddr* get() const noexcept { return reinterpret_cast<const sockaddr*>(&storage_); }
  socklen_t bytes() const noexcept {
    return family() == AF_INET ? sizeof(sockaddr_in) : sizeof(sockaddr_in6);
  }
  int family() const noexcept { return storage_.sin6_family; }

 private:
  SystemAddress() = default;
  sockaddr_in6 storage_{};  ///< a sockaddr_in6, or the shorter sockaddr_in
};

/// Converts an address that the system has filled in; returns the address "any" if its family is neither
/// IPv4 nor IPv6.
SocketAddress to_address(const sockaddr_in6& of_either_family) noexcept;

/// Checks the entries of DiscoverySettings::interfaces. An entry is the name of an interface, one of its
/// addresses, or its network: "10.0.0.0/24", or "10.0.0.0" with the prefix length of the interface. The
/// error names an entry that is none of these.
Result<void> check_interfaces(const std::vector<std::string>& chosen);

/// Returns the addresses of the interfaces that are up. If `chosen` is not empty, only these interfaces
/// count. The order is: addresses of the default routes, other IPv4 addresses, other IPv6 addresses,
/// link-local addresses, and addresses of interfaces without a carrier. Temporary addresses and addresses
/// that are not ready for use are omitted. 127.0.0.1 is returned only if there is no other address. Returns
/// nothing if the system cannot list the addresses at present.
std::optional<std::vector<core::Link>> own_links(const std::vector<std::string>& chosen = {});

/// Returns true if the interface's folder under `interfaces` says that it is wireless.
bool is_wireless(const std::string& interface, const std::string& interfaces = "/sys/class/net");

/// Returns the number of header bytes that IP and UDP put before a datagram.
constexpr std::size_t headers_before_datagram(const core::IpAddress& to) { return to.is_ipv4() ? 28 : 48; }

/// Returns the length of the longest datagram that every path carries in one piece. Its packet has 576 bytes
/// for IPv4 (RFC 791) and 1280 bytes for IPv6 (RFC 8200).
constexpr std::size_t datagram_bytes_of_every_path(const core::IpAddress& to) {
  return to.is_ipv4() ? datagram_bytes_min : 1280 - headers_before_datagram(to);
}

/// Returns the size in bytes of the longest UDP payload that reaches the address in one piece, as far as the
/// kernel knows at present.
std::uint16_t datagram_bytes_to(const SocketAddress& address) noexcept;

}  // namespace sft::udp
