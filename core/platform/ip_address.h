// IP addresses of both families, their networks, and conversion of both from and to text.
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace sft::core {

/// An IP address. An IPv4 address is stored in its IPv6 form, "IPv4-mapped" (RFC 4291, 2.5.5.2):
/// ::ffff:a.b.c.d. All bytes are 0 if there is no address, or for the address "any".
struct IpAddress {
  using Bytes = std::array<std::uint8_t, 16>;

  constexpr IpAddress() = default;
  /// Makes an IPv4 address from a number in host byte order, like INADDR_LOOPBACK. The number 0 makes the
  /// address "any".
  constexpr IpAddress(std::uint32_t ipv4) {  // NOLINT(google-explicit-constructor): as they are written
    if (ipv4 == 0) return;
    bytes = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff};
    for (std::size_t i = 0; i < 4; ++i) bytes[12 + i] = static_cast<std::uint8_t>(ipv4 >> (24 - 8 * i));
  }
  constexpr explicit IpAddress(const Bytes& ipv6, std::uint32_t interface = 0)
      : bytes(ipv6), scope(interface) {}

  constexpr bool is_any() const { return bytes == Bytes{}; }
  constexpr bool is_ipv4() const {
    for (std::size_t i = 0; i < 10; ++i) {
      if (bytes[i] != 0) return false;
    }
    return bytes[10] == 0xff && bytes[11] == 0xff;
  }
  /// Returns the address in host byte order. REQUIRES: is_ipv4().
  constexpr std::uint32_t ipv4() const {
    std::uint32_t number = 0;
    for (std::size_t i = 12; i < 16; ++i) number = number << 8 | bytes[i];
    return number;
  }
  /// Returns true for a link-local IPv6 address, which identifies a host only together with an interface.
  /// (Link-local IPv4 addresses are routed, so they do not count.)
  constexpr bool is_link_local() const { return bytes[0] == 0xfe && (bytes[1] & 0xc0) == 0x80; }
  constexpr bool is_multicast() const { return is_ipv4() ? bytes[12] >> 4 == 0xe : bytes[0] == 0xff; }

  Bytes bytes{};
  std::uint32_t scope = 0;  ///< the index of the interface to which a link-local address belongs

  friend constexpr auto operator<=>(const IpAddress&, const IpAddress&) = default;
};

inline constexpr IpAddress loopback_ipv4{0x7f000001};
inline constexpr IpAddress loopback_ipv6{IpAddress::Bytes{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1}};

/// Returns the address with all bits set to 0 except for the first `prefix_bits`, which is 0 to 32 for IPv4,
/// and 0 to 128 for IPv6.
IpAddress network_of(const IpAddress& address, unsigned prefix_bits);

/// Returns true if both addresses are of the same family and their first `prefix_bits` are equal. Since all
/// link-local networks have the same prefix, the scopes of link-local addresses are compared, too, if both
/// addresses have one.
bool in_one_network(const IpAddress& a, const IpAddress& b, unsigned prefix_bits);

struct IpNetwork {
  IpAddress ip;
  std::optional<unsigned> prefix_bits;  ///< the prefix length; empty: the text has none
  friend bool operator==(const IpNetwork&, const IpNetwork&) = default;
};

/// Returns an address as text: "10.99.1.2", "fd00::7", "fe80::1%eth0".
std::string format(const IpAddress& address);
/// Returns an address with a port as text: "10.99.1.2:7000", "[fe80::1%eth0]:7000".
std::string format(const IpAddress& address, std::uint16_t port);

/// Parses an address in the form of format(). Returns nothing if the text is not an address, or names an
/// interface that this host lacks.
std::optional<IpAddress> parse_ip_address(std::string_view text);
/// Parses an address, or an address with a prefix length: "10.0.0.0/24", "fd00::/64".
std::optional<IpNetwork> parse_ip_network(std::string_view text);

}  // namespace sft::core
