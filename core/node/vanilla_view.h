// Adds the endpoints that the participant for unmodified nodes of DDS and ROS 2 has discovered to a
// DomainSnapshot. A pure function.
#pragma once

#include <set>
#include <vector>

#include "core/node/domain_snapshot.h"
#include "core/vanilla/dds_names.h"
#include "core/vanilla/vanilla_domain.h"
#include "core/vanilla/vanilla_endpoints.h"
#include "sft/domain.h"

namespace sft::core {

struct VanillaView {
  std::vector<VanillaEndpoints::OfTopic> readers{}, writers{};
  std::vector<VanillaParticipant> participants{};
  std::set<EndpointId> of_sft{};  ///< publishers and subscribers of SFT that have a DDS endpoint
  /// Publishers of SFT with a DDS reader that does not acknowledge samples
  std::set<EndpointId> unanswered{};
  DdsNames names{};  ///< the names of topics and types
};

/// Adds the unmodified endpoints, and their pairs with the publishers and subscribers of the snapshot.
void add_vanilla(DomainSnapshot& snapshot, const VanillaView& view, const PairAccounts& accounts);

}  // namespace sft::core
