// The links of this host, and which of them carry multicast well.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/platform/network_monitor.h"

namespace sft::udp {

enum class Multicast : std::uint8_t {
  automatic,  ///< where it puts fewer bytes on the wire, and not on wireless interfaces
  off,
  everywhere,  ///< on loopback and wireless interfaces, too: for tests
};

struct MulticastLink {
  std::string interface;
  std::uint32_t own = 0;  ///< our address there, IPv4, host byte order
  std::uint32_t netmask = 0;
  std::string refusal{};  ///< why not by this one; empty: it may be used
};

/// Returns the links that are up. Asks the system, which takes some 70 us.
std::vector<MulticastLink> multicast_links(Multicast use);

/// The same, asked for once for each change of the network. Of one thread.
class KnownMulticastLinks {
 public:
  using Ask = std::vector<MulticastLink> (*)(Multicast use);
  /// `monitor` outlives it.
  explicit KnownMulticastLinks(core::NetworkMonitor& monitor, Ask ask = multicast_links)
      : monitor_(monitor), ask_(ask) {}

  /// `use`: the same in each call.
  const std::vector<MulticastLink>& list(Multicast use);

 private:
  core::NetworkMonitor& monitor_;
  const Ask ask_;
  std::vector<MulticastLink> links_;
  std::uint64_t changes_ = 0;  ///< those of the network that the list takes into account
};

/// Returns why an interface with these flags (netdevice(7)) is not used for multicast; empty if it may be
/// used. Stations of a wireless network get multicast at the lowest rate, unacknowledged, and many drop it.
std::string why_no_multicast(const std::string& interface, unsigned flags, bool wireless, Multicast use);

}  // namespace sft::udp
