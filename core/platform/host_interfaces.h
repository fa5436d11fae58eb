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
  unsigned index = 0;  ///< differs if the interface was replaced by one of the same name
  IpAddress ip{};      ///< with its scope if it is link-local
  std::uint8_t prefix_bits = 0;
  bool up = true;
  bool running = true;  ///< the interface has a carrier
  bool loopback = false;
  bool multicast = true;  ///< the driver says that the interface can do multicast
  friend bool operator==(const HostInterface&, const HostInterface&) = default;
};

/// Returns the interfaces, including those that are down. IPv6 addresses that are temporary or not ready for
/// use are left out. Returns nothing if the system cannot list them because descriptors are lacking; this
/// must not be taken for a change of the network.
std::optional<std::vector<HostInterface>> host_interfaces();

/// Returns true if `text`, which a user wrote, means this interface: its name, its address, or its network.
/// "10.0.0.0/24" and "10.0.0.0" are networks; the prefix length of the latter is that of the interface.
bool is_named(const HostInterface& interface, const std::string& text);

}  // namespace sft::core
