// Makes a DomainSnapshot from a table of endpoints. Pure.
#pragma once

#include <optional>
#include <vector>

#include "core/control/control.h"
#include "core/node/account_table.h"
#include "sft/domain.h"

namespace sft::core {

struct KnownEndpoint {
  Endpoint endpoint;
  std::optional<Progress> progress{};  ///< of a writer, as it was told last
};

/// `id` and `network` are those of the node that is asked.
DomainSnapshot domain_snapshot(std::vector<KnownEndpoint> endpoints, const PairAccounts& accounts, NodeId id,
                               std::uint64_t network);

}  // namespace sft::core
