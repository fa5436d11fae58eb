// The configuration of Cyclone DDS for the participant that exchanges samples with DDS nodes which know
// nothing of SFT. It is the configuration that a ROS 2 node would have in the same environment: interfaces,
// peers and all other settings are those of the user.
#pragma once

#include <cstdint>
#include <string>

#include "core/vanilla/ros_discovery.h"
#include "sft/result.h"

namespace sft::core {

struct VanillaConfig {
  std::string text;         ///< the argument of dds_create_domain
  bool is_secured = false;  ///< true: the user's configuration contains DDS Security
};

/// The error says what is wrong with the user's configuration.
Result<VanillaConfig> vanilla_config(std::uint32_t domain, const std::string& user_config,
                                     const RosDiscovery& ros = {});

}  // namespace sft::core
