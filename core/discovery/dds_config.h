// The configuration of Cyclone DDS for a domain. SFT's settings come first. The user's settings follow and
// override them. The settings that SFT requires come last.
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
  std::string text;  ///< the settings that all links have in common
  std::string
      domain_on_wire;  ///< the DDS domain of all links on the network; in this process each has another
  bool found_by_multicast = true;  ///< true: nodes on other hosts are found by multicast; false: only by
                                   ///< peers
  bool is_secured = false;         ///< the user's configuration has DDS Security
  /// The port of heartbeats (heartbeat.h). Empty if heartbeats are sent through Cyclone only. This is the
  /// case with DDS Security, because heartbeats have no certificates. It is also the case if the user's
  /// configuration or the lack of multicast may keep heartbeats from arriving, and on links without IPv4.
  std::optional<std::uint16_t> heartbeat_port{};
  std::optional<std::uint16_t> heartbeat_port_on(const LinkSpec& link) const {
    return link.ip.is_ipv4() ? heartbeat_port : std::nullopt;
  }
  /// Hosts to search for nodes, in addition to those that multicast reaches: the peers of the settings and of
  /// the user's configuration.
  std::vector<std::string> peers;
  std::vector<std::string> interfaces;  ///< the chosen interfaces; empty: all interfaces
  std::vector<std::string> warnings;    ///< which of the user's settings do not apply, and why; other hints

  LinkRules rules() const {
    return {.listed = interfaces, .multicast = found_by_multicast, .peers = !peers.empty()};
  }
  /// Returns the configuration for dds_create_domain. A peer that is given by name is included once `hosts`
  /// has its addresses.
  std::string text_for(const LinkSpec& link, const KnownHosts& hosts = {}) const;
  /// Returns the family of the addresses of peers that these links use; nothing if no link uses peers.
  std::optional<IpFamily> family_of_peers(std::span<const LinkSpec> links) const;
  /// Returns a text for people that says how and on which links nodes are found.
  std::string summary(std::span<const LinkSpec> links) const;
};

/// The error says what is wrong with a setting, or with the user's configuration.
Result<DdsConfig> dds_config(std::uint32_t domain, const DiscoverySettings& settings,
                             const std::string& user_config);

/// Returns the names and addresses of the interfaces that the user's configuration chooses. If it chooses
/// none, returns those that `settings` choose.
Result<std::vector<std::string>> discovery_interfaces(std::uint32_t domain, const DiscoverySettings& settings,
                                                      const std::string& user_config);

}  // namespace sft::core
