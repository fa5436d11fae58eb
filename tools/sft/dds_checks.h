// Checks for settings that keep nodes of DDS and ROS 2 out of reach of SFT, as far as the environment and the
// network show them. The checks are pure functions; programs that are started in the same environment have
// the same settings.
#pragma once

#include <sft/domain.h>
#include <string>
#include <vector>

#include "tools/sft/finding.h"

namespace sft::tool {

/// The values of the variables by which nodes of DDS and ROS 2 choose how they find each other. Empty: not
/// set.
struct DdsEnvironment {
  std::string discovery_server{};  ///< ROS_DISCOVERY_SERVER
  std::string transports{};        ///< FASTDDS_BUILTIN_TRANSPORTS
  std::string security{};          ///< ROS_SECURITY_ENABLE
  std::string middleware{};        ///< RMW_IMPLEMENTATION
  std::string range{};             ///< ROS_AUTOMATIC_DISCOVERY_RANGE
  /// CYCLONEDDS_URI, with the contents of a file instead of its name.
  std::string cyclone_config{};

  static DdsEnvironment of_process();
};

/// Returns a warning for each setting and each node that is out of reach, and what DDS nodes there are.
std::vector<Finding> check_dds(const DdsEnvironment& environment, const DomainSnapshot& domain);

/// The time in seconds that nodes of DDS have to announce what they read and write.
inline constexpr double dds_answers_within_s = 5;
/// Returns true if all nodes of DDS have announced something.
bool all_dds_nodes_have_answered(const DomainSnapshot& domain);

}  // namespace sft::tool
