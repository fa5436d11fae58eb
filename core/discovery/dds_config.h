// The configuration of Cyclone DDS for a domain. SFT's settings come first. The user's settings follow and
// override them. Last come the settings that SFT cannot do without.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/discovery/desired_links.h"
#include "core/discovery/ros_discovery.h"
#include "core/platform/host_lookup.h"
#include "core/platform/peer_addresses.h"
#include "sft/options.h"
#include "sft/result.h"

namespace sft::core {

struct DdsConfig {
  std::string text;            ///< the settings that all links have in common
  std::string domain_on_wire;  ///< the number of all links on the network, whatever theirs in this process
  bool multicast = true;       ///< nodes are sent multicasts after they are found, too
  bool found_by_multicast = true;  ///< false: nodes on other hosts are found by peers only
  bool is_secured = false;         ///< the user's configuration has DDS Security
  /// The port of heartbeats (heartbeat.h). Empty if they go by Cyclone only: with DDS Security, since
  /// heartbeats have no certificates, and if the user's configuration or the lack of multicast may keep them
  /// from arriving.
  std::optional<std::uint16_t> heartbeat_port{};
  std::vector<std::string> peers;       ///< hosts to search for nodes, besides those that multicast reaches
  std::vector<std::string> user_peers;  ///< peers that the user's configuration names for all links
  bool text_has_user_peers = true;      ///< false if one is a name: text_for() adds their addresses
  std::vector<std::string> interfaces;  ///< the chosen ones; empty: all
  std::vector<std::string> warnings;    ///< the user's settings that do not apply, and why; other hints

  LinkRules rules() const {
    return {.listed = interfaces,
            .multicast = found_by_multicast,
            .peers = !peers.empty() || !user_peers.empty()};
  }
  /// Returns the configuration for dds_create_domain. It contains peers by name once their addresses are
  /// known.
  std::string text_for(const LinkSpec& link, const KnownHosts& hosts = {}) const;
  /// Returns the family of the addresses at which these links ask peers; nothing if no link asks peers.
  std::optional<IpFamily> family_of_peers(std::span<const LinkSpec> links) const;
  /// Says for people how and where nodes are found.
  std::string summary(std::span<const LinkSpec> links) const;
};

/// The error says what is wrong with a setting, or with the user's configuration.
Result<DdsConfig> dds_config(std::uint32_t domain, const DiscoverySettings& settings,
                             const std::string& user_config);

/// The configuration of the participant that serves and hears DDS nodes which know nothing of SFT. It is that
/// of a ROS 2 node in the same environment: interfaces, peers and all other settings are those of the user.
struct VanillaConfig {
  std::string text;         ///< the argument of dds_create_domain
  bool is_secured = false;  ///< the user's configuration has DDS Security
};
Result<VanillaConfig> vanilla_config(std::uint32_t domain, const std::string& user_config,
                                     const RosDiscovery& ros = {});

/// Returns the names and addresses of the interfaces that the user's configuration chooses, or else the
/// settings.
Result<std::vector<std::string>> discovery_interfaces(std::uint32_t domain, const DiscoverySettings& settings,
                                                      const std::string& user_config);

}  // namespace sft::core
