// The range in which nodes of ROS 2 search for each other, according to the environment variables of ROS 2.
// SFT's own discovery has separate settings, but the participant for unmodified nodes must find the nodes
// that a node of ROS 2 would find. Pure functions.
#pragma once

#include <string>
#include <vector>

#include "sft/result.h"

namespace sft::core {

struct RosDiscovery {
  bool is_off = false;         ///< true: no other node must be found
  bool loopback_only = false;  ///< true: only the interface of the loopback is used, as by nodes of Humble
  /// True: only this host is searched, by unicast, as by nodes of Iron and later
  bool localhost_only = false;
  std::vector<std::string> peers{};  ///< hosts that are searched in addition
};

/// Returns the settings in the values of these environment variables, each of which may be null. The error
/// names the possible values.
Result<RosDiscovery> ros_discovery(const char* localhost_only,   // ROS_LOCALHOST_ONLY
                                   const char* discovery_range,  // ROS_AUTOMATIC_DISCOVERY_RANGE
                                   const char* static_peers);    // ROS_STATIC_PEERS

}  // namespace sft::core
