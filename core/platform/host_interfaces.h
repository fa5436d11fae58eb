// The network interfaces of this host, as the system lists them, and how the settings of users name them.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/platform/ip_address.h"
#include "sft/result.h"

namespace sft::core {

/// One address of one interface. An interface without a usable address is listed once, with no address.
struct HostInterface {
  std::string name;
  /// The index of the interface; it changes if the interface is replaced by one of the same name.
  unsigned index = 0;
  IpAddress ip{};  ///< the address; with its scope if it is link-local
  std::uint8_t prefix_bits = 0;
  bool up = true;
  bool running = true;  ///< the interface has a carrier
  bool loopback = false;
  bool multicast = true;  ///< the driver reports that the interface supports multicast
  friend bool operator==(const HostInterface&, const HostInterface&) = default;
};

/// Returns the interfaces, including those that are down. IPv6 addresses that are temporary or not ready
/// for use are left out. Returns an error with the reason of the system if it cannot list the interfaces, for
/// example because no descriptor is free. This does not mean that the network has changed.
Result<std::vector<HostInterface>> host_interfaces();
/// Does the same. `index_of` is if_nametoindex(), or a substitute in tests: it returns the index of the
/// interface of that name, or 0 if it fails, with the reason in errno.
Result<std::vector<HostInterface>> host_interfaces(const std::function<unsigned(const char* name)>& index_of);

/// Returns true if `text`, which a user has written, is the name, the address or the network of the
/// interface. "10.0.0.0/24" and "10.0.0.0" are networks; the prefix length of the latter is that of the
/// interface.
bool is_named(const HostInterface& interface, const std::string& text);

}  // namespace sft::core
