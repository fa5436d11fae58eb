// Decides which links discovery should have. A link is one address of one network interface. A domain of
// Cyclone DDS uses one interface, which is chosen once, so each link gets a Cyclone domain of its own. The
// functions are pure: interfaces and settings go in, links come out. discovery.md has the rules.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/platform/host_interfaces.h"

namespace sft::core {

/// The greatest number of links. Each link costs five threads.
inline constexpr std::size_t links_max = 8;

struct LinkSpec {
  std::string interface;
  IpAddress ip{};  ///< IPv4; none if the host has only IPv6, where the name identifies the link
  std::uint8_t prefix_bits = 0;
  bool loopback = false;
  /// Multicasts of the link return to this host. That is needed only if there is no loopback link by which
  /// nodes of one host find each other.
  bool reaches_own_host = false;
  unsigned index = 0;  ///< of the interface; sockets lose their multicast groups when it is removed
  friend auto operator<=>(const LinkSpec&, const LinkSpec&) = default;
};

struct LinkRules {
  std::vector<std::string> listed{};  ///< names, addresses or networks; empty: all interfaces
  bool multicast = true;              ///< false: nodes on other hosts are found by peers only
  bool peers = false;                 ///< there are hosts to search for nodes, which needs no multicast
};

struct DesiredLinks {
  std::vector<LinkSpec> links{};
  /// For people: listed interfaces that are not in use, with the reason, and interfaces beyond the limit.
  std::vector<std::string> remarks{};
  /// No interface but the loopback is in use, although others are wanted.
  bool waits_for_network = false;
};

/// `in_force`: the present links. Each stays as long as its address exists, even if the interface is down,
/// because the kernel keeps the multicast groups that sockets have joined there.
DesiredLinks desired_links(std::span<const HostInterface> interfaces, const LinkRules& rules,
                           std::span<const LinkSpec> in_force);

/// Returns true if the address is in the network of the link.
bool leads_to(const LinkSpec& link, const IpAddress& address);

/// Returns text for people: "lo, wlan0 (10.0.0.5)".
std::string describe(std::span<const LinkSpec> links);

/// Returns true if container engines give such names to their bridges and cables. No other host is behind
/// these.
bool belongs_to_containers(const std::string& interface);

}  // namespace sft::core
