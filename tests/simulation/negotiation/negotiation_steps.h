// The steps that a world of negotiations may take: which kinds there are, and which of them may come next.
#pragma once

#include <cstdint>
#include <vector>

#include "tests/simulation/negotiation/negotiation_state.h"

namespace sft::test {

struct NegotiationStep {
  enum class What : std::uint8_t {
    word_comes,
    word_repeated,
    agent_reconciles,
    agent_looks_after_connections,
    daemon_connects,
    selection_changes,
    rate_changes,
    node_lost,
    node_found,
    lost_forgotten,
    memory_changes,
    node_killed,
    node_started,
    endpoint_departs,
    sample_published,
    datagram_comes,
    datagram_lost,
    history_leaves,
  };

  What what{};
  std::uint8_t node = 0;   ///< to which it happens
  std::uint8_t other = 0;  ///< where it comes from, or which of several
};

/// Replaces `steps` by all that may happen next.
void list_steps(const NegotiationState& state, std::vector<NegotiationStep>& steps);

}  // namespace sft::test
