// The participant of this process in the DDS domain of unmodified nodes of DDS and ROS 2. The links of
// discovery cannot be used for samples, because each link is bound to one interface and has settings of
// SFT. This participant has the settings that a ROS 2 node would have in the same environment.
#pragma once

#include <dds/dds.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/vanilla/dds_names.h"
#include "core/vanilla/ros_discovery.h"
#include "core/vanilla/ros_graph.h"
#include "core/vanilla/vanilla_endpoints.h"
#include "sft/options.h"
#include "sft/result.h"

namespace sft::core {

class CycloneDomain;

struct VanillaPlan {
  std::uint32_t domain = 0;
  std::string user_config{};  ///< XML texts or names of files
  RosDiscovery ros{};         ///< the settings in the environment; `user_config` overrides them
  DdsNames names{};           ///< the names of topics and types
  ThreadSettings threads{};   ///< the settings of Cyclone's threads
  /// The size of GUIDs in the graph of ROS 2, if the environment names a distribution.
  std::optional<GuidBytes> guid_bytes{};
};

/// A participant that is not one of SFT.
struct VanillaParticipant {
  std::string name;    ///< the result of name_of_participant()
  std::string host{};  ///< the host that the participant announces; may be empty
  /// The process that the participant announces, such as "talker (4711)"; may be empty
  std::string process{};
};

class VanillaDomain {
 public:
  /// Returns the participant that the nodes of this process with an equal plan share. Makes it if there is
  /// none.
  static Result<std::shared_ptr<VanillaDomain>> of(const VanillaPlan& plan);

  VanillaDomain(std::shared_ptr<const CycloneDomain> domain, dds_entity_t participant,
                std::optional<GuidBytes> guid_bytes = {});
  /// Waits for threads of Cyclone. All endpoints of the participant must have been deleted before.
  ~VanillaDomain();
  VanillaDomain(const VanillaDomain&) = delete;
  VanillaDomain& operator=(const VanillaDomain&) = delete;

  dds_entity_t participant() const { return participant_; }
  /// The unmodified readers that the participant has discovered.
  VanillaEndpoints& readers() { return *readers_; }
  const VanillaEndpoints& readers() const { return *readers_; }
  /// The nodes of this process and of ROS 2. Objects of LocalNode must not outlive the domain.
  RosGraph& graph() { return *graph_; }
  /// Returns the other participants of the domain, at most 1024.
  std::vector<VanillaParticipant> participants() const;

 private:
  const std::shared_ptr<const CycloneDomain> domain_;
  const dds_entity_t participant_;
  const dds_entity_t announced_;  ///< a reader of the announcements of participants
  std::optional<VanillaEndpoints> readers_;
  std::optional<RosGraph> graph_;
};

/// Returns true if the program itself uses DDS: it has opened that domain by Cyclone DDS, or has loaded a
/// library of ROS 2 or Fast DDS. Such a program may forward messages from DDS to SFT, and would receive its
/// own messages again if its publishers served DDS readers.
bool program_speaks_dds(std::uint32_t domain);

}  // namespace sft::core
