// The addresses of readers, and the identity of an endpoint.
#pragma once

#include <array>
#include <cstdint>
#include <variant>

#include "core/platform/ip_address.h"

namespace sft::core {

using EndpointId = std::uint64_t;  ///< random per incarnation, never 0; datagrams carry its low 32 bits

/// The address to which datagrams for a reader are sent.
struct UdpAddress {
  IpAddress ip;
  std::uint16_t port = 0;
  /// The receive buffer of the socket, in bytes as the kernel counts. A sender paces bursts by it.
  std::uint32_t receive_buffer_bytes = 0;
  bool wireless = false;  ///< true if the interface of this address is wireless
  /// A random number of the node that owns the socket, new for each incarnation. Of two addresses with equal
  /// numbers and ports, the newer one replaces the other. 0: it is not known which other addresses the socket
  /// has.
  std::uint64_t node = 0;
  friend bool operator==(const UdpAddress&, const UdpAddress&) = default;
};

/// One of our own addresses, and the network that it is in.
struct Link {
  IpAddress ip;  ///< with its scope if it is link-local
  std::uint8_t prefix_bits = 0;
  bool running = true;  ///< its interface has a carrier
  bool wireless = false;
  friend bool operator==(const Link&, const Link&) = default;
};

/// The doorbell (core/platform/doorbell.h) that is rung when a sample for a reader was put into shared
/// memory.
struct DoorbellAddress {
  std::uint64_t page = 0;
  std::uint32_t slot = 0;
  friend bool operator==(const DoorbellAddress&, const DoorbellAddress&) = default;
};

using Locator = std::variant<UdpAddress, DoorbellAddress>;

/// The identity of the memory that processes of one host share: boot_id and the token that the daemon wrote
/// to /dev/shm.
struct HostToken {
  std::array<std::uint8_t, 32> bytes{};
  bool known() const { return bytes != std::array<std::uint8_t, 32>{}; }
  friend bool operator==(const HostToken&, const HostToken&) = default;
};

}  // namespace sft::core
