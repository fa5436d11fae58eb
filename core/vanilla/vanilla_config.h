// The configuration of Cyclone DDS for the participant that serves and hears DDS nodes which know nothing of
// SFT. It is that of a ROS 2 node in the same environment: interfaces, peers and all other settings are those
// of the user.
#pragma once

#include <cstdint>
#include <string>

#include "core/vanilla/ros_discovery.h"
#include "sft/result.h"

namespace sft::core {

struct VanillaConfig {
  std::string text;         ///< the argument of dds_create_domain
  bool is_secured = false;  ///< the user's configuration has DDS Security
};

/// The error says what is wrong with the user's configuration.
Result<VanillaConfig> vanilla_config(std::uint32_t domain, const std::string& user_config,
                                     const RosDiscovery& ros = {});

}  // namespace sft::core
