// The configuration of Cyclone DDS for a domain. SFT's settings come first, then the user's, so that these
// win, and last the settings that SFT cannot do without.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/discovery/desired_links.h"
#include "core/platform/host_lookup.h"
#include "core/platform/peer_addresses.h"
#include "sft/options.h"
#include "sft/result.h"

namespace sft::core {

struct DdsConfig {
  std::string text;                ///< what all links have in common
  std::string domain_on_wire;      ///< all links are one DDS domain, whatever their numbers in this process
  bool multicast = true;           ///< one datagram can reach several nodes once they are found
  bool found_by_multicast = true;  ///< else nodes elsewhere are found by peers only
  bool is_secured = false;         ///< the user's configuration has DDS Security
  /// The port of heartbeats (heartbeat.h). Nothing where there are none: where nodes have certificates, which
  /// heartbeats have not, or where the user's configuration or the lack of multicast may keep them from
  /// arriving.
  std::optional<std::uint16_t> heartbeat_port{};
  std::vector<std::string> peers;  ///< hosts that are looked for nodes, besides those that multicast reaches
  std::vector<std::string> user_peers;  ///< peers that the user's configuration names for all links
  bool text_has_user_peers = true;      ///< false: one of them is a name, so text_for() writes their numbers
  std::vector<std::string> interfaces;  ///< that are chosen; empty: all
  std::vector<std::string> warnings;    ///< what does not hold of the user's, and why; what to know of it

  LinkRules rules() const {
    return {.listed = interfaces,
            .multicast = found_by_multicast,
            .peers = !peers.empty() || !user_peers.empty()};
  }
  /// The configuration for dds_create_domain. Peers by name are in it once their addresses are known.
  std::string text_for(const LinkSpec& link, const KnownHosts& hosts = {}) const;
  /// Returns the family of the addresses that these links ask. Returns nothing if no link asks peers.
  std::optional<IpFamily> family_of_peers(std::span<const LinkSpec> links) const;
  /// For people: how and where nodes are found.
  std::string summary(std::span<const LinkSpec> links) const;
};

/// The error says what is wrong with a setting, or with the user's configuration.
Result<DdsConfig> dds_config(std::uint32_t domain, const DiscoverySettings& settings,
                             const std::string& user_config);

/// The configuration of the participant that serves DDS nodes which know nothing of SFT. It is that of a ROS
/// 2 node in the same environment: interfaces, peers and the rest are the user's.
struct VanillaConfig {
  std::string text;         ///< for dds_create_domain
  bool is_secured = false;  ///< the user's configuration has DDS Security
};
Result<VanillaConfig> vanilla_config(std::uint32_t domain, const std::string& user_config);

/// Names and addresses of the interfaces that the user's configuration names, or else the settings.
Result<std::vector<std::string>> discovery_interfaces(std::uint32_t domain, const DiscoverySettings& settings,
                                                      const std::string& user_config);

}  // namespace sft::core
