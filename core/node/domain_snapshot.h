// Makes a DomainSnapshot from a table of endpoints. A pure function.
#pragma once

#include <optional>
#include <vector>

#include "core/control/control.h"
#include "core/node/account_table.h"
#include "sft/domain.h"

namespace sft::core {

struct KnownEndpoint {
  Endpoint endpoint;
  std::optional<Progress> progress{};  ///< the last report of a writer's progress
};

/// Makes the snapshot. `id` and `network` are those of the node that makes the snapshot.
DomainSnapshot domain_snapshot(std::vector<KnownEndpoint> endpoints, const PairAccounts& accounts, NodeId id,
                               std::uint64_t network);

}  // namespace sft::core
