// The kinds of steps of a world of negotiations, and the list of possible next steps.
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
  std::uint8_t node = 0;   ///< the node of the step
  std::uint8_t other = 0;  ///< the sending node, or the index of one of several objects
};

/// Replaces `steps` by all possible next steps.
void list_steps(const NegotiationState& state, std::vector<NegotiationStep>& steps);

}  // namespace sft::test
