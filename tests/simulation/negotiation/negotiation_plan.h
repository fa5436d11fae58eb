// A plan of nodes and endpoints, and of how much may happen to them.
#pragma once

#include <cstddef>
#include <vector>

#include "core/control/control.h"

namespace sft::test {

struct NegotiationPlan {
  struct Endpoint {
    std::size_t place = 0;  ///< of the node
    core::Role role{};
    bool may_use_memory = true;
    bool may_use_network = true;
    core::Qos qos{};
  };
  /// The number of times that each event may happen which is not the protocol's own doing.
  struct Budget {
    int selection_changes = 0;
    int rate_changes = 0;
    int losses = 0;  ///< one node does not hear another any more, for a while
    int memory_changes = 0;
    int restarts = 0;  ///< killed, and started again
    int departures = 0;
    int repetitions = 0;
    int samples = 0;
  };

  std::size_t places = 2;
  std::vector<Endpoint> endpoints;
  Budget budget;
  bool common_memory = true;  ///< at the beginning
};

}  // namespace sft::test
