// The range in which nodes of ROS 2 look for each other, as its environment variables say. SFT's own
// discovery has settings of its own; the participant for unmodified nodes has to find those that ROS 2 would
// find. Pure.
#pragma once

#include <string>
#include <vector>

#include "sft/result.h"

namespace sft::core {

struct RosDiscovery {
  bool is_off = false;               ///< no other node is to be found
  bool loopback_only = false;        ///< by the interface of the loopback, as nodes of Humble
  bool localhost_only = false;       ///< by asking this host, as nodes of Iron and later
  std::vector<std::string> peers{};  ///< hosts that are asked as well
};

/// Returns what these values of environment variables say; each may be null. The error names the possible
/// values.
Result<RosDiscovery> ros_discovery(const char* localhost_only,   // ROS_LOCALHOST_ONLY
                                   const char* discovery_range,  // ROS_AUTOMATIC_DISCOVERY_RANGE
                                   const char* static_peers);    // ROS_STATIC_PEERS

}  // namespace sft::core
