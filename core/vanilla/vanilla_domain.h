// The participant of this process in a DDS domain as unmodified nodes of DDS and ROS 2 use it. The links of
// discovery cannot carry samples: each is bound to one interface, and to settings of SFT. This participant
// has the settings that a ROS 2 node would have in the same environment.
#pragma once

#include <dds/dds.h>

#include <cstdint>
#include <memory>
#include <string>

#include "core/vanilla/vanilla_readers.h"
#include "sft/options.h"
#include "sft/result.h"

namespace sft::core {

class CycloneDomain;

struct VanillaPlan {
  std::uint32_t domain = 0;
  std::string user_config{};  ///< XML texts or names of files
  ThreadSettings threads{};   ///< of Cyclone's threads
};

class VanillaDomain {
 public:
  /// The one that nodes of this process with an equal plan have, or a new one.
  static Result<std::shared_ptr<VanillaDomain>> of(const VanillaPlan& plan);

  VanillaDomain(std::shared_ptr<const CycloneDomain> domain, dds_entity_t participant);
  /// Its endpoints are gone before. Waits for threads of Cyclone.
  ~VanillaDomain();
  VanillaDomain(const VanillaDomain&) = delete;
  VanillaDomain& operator=(const VanillaDomain&) = delete;

  dds_entity_t participant() const { return participant_; }
  const VanillaReaders& readers() const { return readers_; }

 private:
  const std::shared_ptr<const CycloneDomain> domain_;
  const dds_entity_t participant_;
  VanillaReaders readers_;
};

/// True if the program itself speaks DDS, in that domain by Cyclone DDS, or by a library of ROS 2 or Fast DDS
/// that is loaded. Such a program may pass messages of DDS on to SFT, and would get back what it publishes.
bool program_speaks_dds(std::uint32_t domain);

}  // namespace sft::core
