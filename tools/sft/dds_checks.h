// Checks for settings that prevent nodes of DDS and ROS 2 from finding SFT, as far as the environment and
// the network show these settings. The checks are pure functions. Programs that are started in the same
// environment have the same settings.
#pragma once

#include <sft/domain.h>
#include <string>
#include <vector>

#include "tools/sft/finding.h"

namespace sft::tool {

/// The values of environment variables with which nodes of DDS and ROS 2 choose how they find each other.
/// An empty text means that the variable is not set.
struct DdsEnvironment {
  std::string discovery_server{};  ///< ROS_DISCOVERY_SERVER
  std::string transports{};        ///< FASTDDS_BUILTIN_TRANSPORTS
  std::string security{};          ///< ROS_SECURITY_ENABLE
  std::string middleware{};        ///< RMW_IMPLEMENTATION
  std::string range{};             ///< ROS_AUTOMATIC_DISCOVERY_RANGE
  /// The value of CYCLONEDDS_URI; if it names a file, the contents of the file.
  std::string cyclone_config{};

  static DdsEnvironment of_process();
};

/// Returns a warning for each setting and each node that prevents communication, and a finding that lists
/// the DDS nodes.
std::vector<Finding> check_dds(const DdsEnvironment& environment, const DomainSnapshot& domain);

/// The time in seconds that nodes of DDS have to announce what they read and write.
inline constexpr double dds_answers_within_s = 5;
/// Returns true if all nodes of DDS have announced something.
bool all_dds_nodes_have_answered(const DomainSnapshot& domain);

}  // namespace sft::tool
