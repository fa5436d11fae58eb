// Makes a DomainSnapshot from a table of endpoints. A pure function.
#pragma once

#include <map>
#include <vector>

#include "core/control/control.h"
#include "core/negotiation/endpoint_table.h"
#include "sft/domain.h"

namespace sft::core {

/// The accounts of pairs, as far as they are known.
using PairAccounts = std::map<PairId, DomainSnapshot::Account>;

/// Makes the snapshot. `id` and `network` are those of the node that makes the snapshot.
DomainSnapshot domain_snapshot(std::vector<TableEntry> endpoints, const PairAccounts& accounts, NodeId id,
                               std::uint64_t network);

}  // namespace sft::core
