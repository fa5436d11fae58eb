// The links of this host, and whether multicast is used on them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/platform/network_monitor.h"

namespace sft::udp {

enum class Multicast : std::uint8_t {
  automatic,  ///< multicast is used if it saves bytes on the wire, but not on wireless interfaces
  off,
  everywhere,  ///< multicast is used on loopback and wireless interfaces, too; for tests
};

struct MulticastLink {
  std::string interface;
  std::uint32_t own = 0;  ///< our IPv4 address on the link, host byte order
  std::uint32_t netmask = 0;
  std::string refusal{};  ///< reason why this link is not used for multicast; empty: it may be used
};

/// Returns the links that are up. The system call for their list takes about 70 us.
std::vector<MulticastLink> multicast_links(Multicast use);

/// Keeps the list of links, and requests it from the system only if the network has changed. An object must
/// be used by only one thread.
class KnownMulticastLinks {
 public:
  using Ask = std::vector<MulticastLink> (*)(Multicast use);
  /// `monitor` must outlive this object.
  explicit KnownMulticastLinks(core::NetworkMonitor& monitor, Ask ask = multicast_links)
      : monitor_(monitor), ask_(ask) {}

  /// Returns the links. `use` must be the same in each call.
  const std::vector<MulticastLink>& list(Multicast use);

 private:
  core::NetworkMonitor& monitor_;
  const Ask ask_;
  std::vector<MulticastLink> links_;
  std::uint64_t changes_ = 0;  ///< value of NetworkMonitor::changes() when the list was made
};

/// Returns the reason why an interface with these flags (netdevice(7)) is not used for multicast; empty if
/// it may be used. Wireless networks send multicast at the lowest rate and without acknowledgement, and many
/// of them drop multicast.
std::string why_no_multicast(const std::string& interface, unsigned flags, bool wireless, Multicast use);

}  // namespace sft::udp
