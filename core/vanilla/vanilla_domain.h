// The participant of this process in a DDS domain as unmodified nodes of DDS and ROS 2 use it. The links of
// discovery cannot carry samples: each is bound to one interface, and to settings of SFT. This participant
// has the settings that a ROS 2 node would have in the same environment.
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
  RosDiscovery ros{};         ///< what the environment says; `user_config` overrides it
  DdsNames names{};           ///< the names of topics and types
  ThreadSettings threads{};   ///< of Cyclone's threads
  /// The size of GUIDs in the graph of ROS 2, if the environment says it.
  std::optional<GuidBytes> guid_bytes{};
};

/// A participant that is not one of SFT.
struct VanillaParticipant {
  std::string name;       ///< as name_of_participant() says
  std::string host{};     ///< what it says of itself; empty: nothing
  std::string process{};  ///< the same: "talker (4711)"
};

class VanillaDomain {
 public:
  /// Returns the participant that nodes of this process with an equal plan share, or makes a new one.
  static Result<std::shared_ptr<VanillaDomain>> of(const VanillaPlan& plan);

  VanillaDomain(std::shared_ptr<const CycloneDomain> domain, dds_entity_t participant,
                std::optional<GuidBytes> guid_bytes = {});
  /// All its endpoints must have been deleted before. Waits for threads of Cyclone.
  ~VanillaDomain();
  VanillaDomain(const VanillaDomain&) = delete;
  VanillaDomain& operator=(const VanillaDomain&) = delete;

  dds_entity_t participant() const { return participant_; }
  /// The unmodified readers that the participant has discovered.
  VanillaEndpoints& readers() { return *readers_; }
  const VanillaEndpoints& readers() const { return *readers_; }
  /// The nodes of this process and of ROS 2. Its LocalNodes must not outlive the domain.
  RosGraph& graph() { return *graph_; }
  /// Returns the other participants of the domain, at most 1024.
  std::vector<VanillaParticipant> participants() const;

 private:
  const std::shared_ptr<const CycloneDomain> domain_;
  const dds_entity_t participant_;
  const dds_entity_t announced_;  ///< the reader of what participants announce
  std::optional<VanillaEndpoints> readers_;
  std::optional<RosGraph> graph_;
};

/// Returns true if the program itself uses DDS: it has opened that domain by Cyclone DDS, or has loaded a
/// library of ROS 2 or Fast DDS. Such a program may forward messages from DDS to SFT, and would receive its
/// own messages again if its publishers served DDS readers.
bool program_speaks_dds(std::uint32_t domain);

}  // namespace sft::core
