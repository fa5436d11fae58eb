// How Cyclone DDS is configured for a domain: by ours first, then by the user's, so that it wins, and last by
// what SFT cannot do without.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sft/options.h"
#include "sft/typesupport/result.h"

namespace sft::core {

struct DdsConfig {
  std::string text;                   ///< for dds_create_domain
  bool multicast = true;              ///< one datagram can reach several nodes once they are found
  std::string summary;                ///< how nodes are found
  std::vector<std::string> warnings;  ///< what does not hold of the user's, and why; what to know of it
};

/// The error says what is wrong with a setting, or with the user's configuration.
Result<DdsConfig> dds_config(std::uint32_t domain, const DiscoverySettings& settings,
                             const std::string& user_config);

/// Names and addresses of the interfaces that the user's configuration names, or else the settings.
Result<std::vector<std::string>> discovery_interfaces(std::uint32_t domain, const DiscoverySettings& settings,
                                                      const std::string& user_config);

}  // namespace sft::core
