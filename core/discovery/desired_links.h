// Decides which links discovery should have. A link is one address of one network interface. A domain of
// Cyclone DDS uses one interface, which is chosen once, so each link gets a separate Cyclone domain. The
// functions are pure: interfaces and settings are passed in, links are returned. discovery.md has the
// rules.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/platform/host_interfaces.h"

namespace sft::core {

/// The maximum number of links. Each link costs five threads.
inline constexpr std::size_t links_max = 8;

struct LinkSpec {
  std::string interface {};
  IpAddress ip{};  ///< IPv4; none if the interface has only IPv6, where the name identifies the link
  std::uint8_t prefix_bits = 0;
  bool loopback = false;
  /// Multicasts of the link are looped back to this host. Only the loopback link needs this, or all links if
  /// there is none, since nodes of one host have to find each other.
  bool reaches_own_host = false;
  unsigned index = 0;  ///< the index of the interface; sockets lose their multicast groups when the interface
                       ///< is removed
  friend auto operator<=>(const LinkSpec&, const LinkSpec&) = default;
};

struct LinkRules {
  std::vector<std::string> listed{};  ///< names, addresses or networks; empty: all interfaces
  bool multicast = true;              ///< true: nodes on other hosts are found by multicast; false: only by
                                      ///< peers
  bool peers = false;                 ///< there are peers, which can be searched for nodes without multicast
};

struct DesiredLinks {
  std::vector<LinkSpec> links{};
  /// For people: the listed interfaces that are not in use, each with the reason, and the interfaces that
  /// exceed `links_max`.
  std::vector<std::string> remarks{};
  /// True if only the loopback interface is in use, although other interfaces are wanted.
  bool waits_for_network = false;
};

/// `in_force`: the present links. Each present link is kept as long as its address exists, even if the
/// interface is down, because the kernel keeps the multicast groups that sockets have joined there.
DesiredLinks desired_links(std::span<const HostInterface> interfaces, const LinkRules& rules,
                           std::span<const LinkSpec> in_force);

/// Returns true if the address is in the network of the link.
bool leads_to(const LinkSpec& link, const IpAddress& address);

/// Returns text for people: "lo, wlan0 (10.0.0.5)".
std::string describe(std::span<const LinkSpec> links);

/// Returns true if container engines give such names to their bridges and cables. No other host can be
/// reached by such interfaces.
bool belongs_to_containers(const std::string& interface);

}  // namespace sft::core
