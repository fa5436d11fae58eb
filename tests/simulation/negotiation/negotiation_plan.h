// A plan of nodes and endpoints, with a maximum number of events of each kind.
#pragma once

#include <cstddef>
#include <vector>

#include "core/control/control.h"

namespace sft::test {

struct NegotiationPlan {
  struct Endpoint {
    std::size_t place = 0;  ///< the place of the endpoint's node
    core::Role role{};
    bool may_use_memory = true;
    bool may_use_network = true;
    core::Qos qos{};
  };
  /// The numbers of events that may still happen. None of these events is part of the protocol.
  struct Budget {
    int selection_changes = 0;
    int rate_changes = 0;
    int losses = 0;  ///< the number of times that a node loses another for a while
    int memory_changes = 0;
    int restarts = 0;  ///< the number of times that a node is killed and started again
    int departures = 0;
    int repetitions = 0;
    int samples = 0;
  };

  std::size_t places = 2;
  std::vector<Endpoint> endpoints;
  Budget budget;
  bool common_memory = true;  ///< whether all nodes share memory at the beginning
};

}  // namespace sft::test
