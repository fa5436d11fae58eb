// The network interfaces of this host, as the system lists them, and how users name them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/platform/ip_address.h"

namespace sft::core {

/// One address of one interface. An interface that has no usable address is listed once, with no address.
struct HostInterface {
  std::string name;
  unsigned index = 0;  ///< another one if the interface was replaced by one of the same name
  IpAddress ip{};      ///< a link-local one with its scope
  std::uint8_t prefix_bits = 0;
  bool up = true;
  bool running = true;  ///< has a carrier
  bool loopback = false;
  bool multicast = true;  ///< the driver says that it can
  friend bool operator==(const HostInterface&, const HostInterface&) = default;
};

/// Interfaces that are down are listed, too. IPv6 addresses that are temporary or not ready for use are not.
/// Nothing while the system cannot list them, for want of descriptors: that says nothing of the network.
std::optional<std::vector<HostInterface>> host_interfaces();

/// True if a user who writes `text` means this interface: its name, its address, or the network that it is
/// in. "10.0.0.0/24" and "10.0.0.0" are networks; the second is as long as the interface says.
bool is_named(const HostInterface& interface, const std::string& text);

}  // namespace sft::core
