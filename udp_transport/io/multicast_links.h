// The links of this host, and which of them carry multicast well.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/platform/network_monitor.h"

namespace sft::udp {

enum class Multicast : std::uint8_t {
  automatic,  ///< where it puts fewer bytes on the wire, but not on wireless interfaces
  off,
  everywhere,  ///< on loopback and wireless interfaces, too: for tests
};

struct MulticastLink {
  std::string interface;
  std::uint32_t own = 0;  ///< our IPv4 address on the link, host byte order
  std::uint32_t netmask = 0;
  std::string refusal{};  ///< why this link is not used for multicast; empty: it may be used
};

/// Returns the links that are up. Asks the system, which takes some 70 us.
std::vector<MulticastLink> multicast_links(Multicast use);

/// Keeps the list of links, and asks the system only if the network has changed. Used by one thread.
class KnownMulticastLinks {
 public:
  using Ask = std::vector<MulticastLink> (*)(Multicast use);
  /// `monitor` outlives this object.
  explicit KnownMulticastLinks(core::NetworkMonitor& monitor, Ask ask = multicast_links)
      : monitor_(monitor), ask_(ask) {}

  /// `use` is the same in each call.
  const std::vector<MulticastLink>& list(Multicast use);

 private:
  core::NetworkMonitor& monitor_;
  const Ask ask_;
  std::vector<MulticastLink> links_;
  std::uint64_t changes_ = 0;  ///< count of network changes when the list was made
};

/// Returns why an interface with these flags (netdevice(7)) is not used for multicast; empty if it may be
/// used. Wireless networks send multicast at the lowest rate and unacknowledged, and many drop it.
std::string why_no_multicast(const std::string& interface, unsigned flags, bool wireless, Multicast use);

}  // namespace sft::udp
