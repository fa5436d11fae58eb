// The endpoints that the participant for unmodified nodes of DDS and ROS 2 has discovered, as a part of a
// DomainSnapshot.
// A pure function.
#pragma once

#include <set>
#include <vector>

#include "core/node/account_table.h"
#include "core/vanilla/dds_names.h"
#include "core/vanilla/vanilla_domain.h"
#include "core/vanilla/vanilla_endpoints.h"
#include "sft/domain.h"

namespace sft::core {

struct VanillaView {
  std::vector<VanillaEndpoints::OfTopic> readers{}, writers{};
  std::vector<VanillaParticipant> participants{};
  std::set<EndpointId> of_sft{};      ///< publishers and subscribers of SFT that have a DDS endpoint
  std::set<EndpointId> unanswered{};  ///< publishers of SFT that some DDS reader does not answer
  DdsNames names{};                   ///< of topics and types
};

/// Adds the unmodified endpoints, and their pairs with the publishers and subscribers of the snapshot.
void add_vanilla(DomainSnapshot& snapshot, const VanillaView& view, const PairAccounts& accounts);

}  // namespace sft::core
