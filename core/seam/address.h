// The addresses of readers, and the identity of an endpoint.
#pragma once

#include <array>
#include <cstdint>
#include <variant>

#include "core/platform/ip_address.h"

namespace sft::core {

/// A random number that is new each time that an endpoint is opened; never 0. Datagrams contain its low 32
/// bits.
using EndpointId = std::uint64_t;

/// The address to which datagrams for a reader are sent.
struct UdpAddress {
  IpAddress ip;
  std::uint16_t port = 0;
  /// The size of the socket's receive buffer in bytes, as the kernel counts it. A sender limits its bursts
  /// by this size.
  std::uint32_t receive_buffer_bytes = 0;
  bool wireless = false;  ///< true if the interface of this address is wireless
  /// A random number of the node that owns the socket, new each time that the node is opened. If two
  /// addresses have equal numbers and ports, the newer one replaces the other. 0: unknown.
  std::uint64_t node = 0;
  friend bool operator==(const UdpAddress&, const UdpAddress&) = default;
};

/// One address of this host, and the network that the address is in.
struct Link {
  IpAddress ip;  ///< the address; with its scope if it is link-local
  std::uint8_t prefix_bits = 0;
  bool running = true;  ///< true: the interface has a carrier
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

/// The identity of the memory that processes of one host share: the boot id of the host, and the token that
/// the daemon wrote to /dev/shm.
struct HostToken {
  std::array<std::uint8_t, 32> bytes{};
  bool known() const { return bytes != std::array<std::uint8_t, 32>{}; }
  friend bool operator==(const HostToken&, const HostToken&) = default;
};

}  // namespace sft::core
