// One round of one contender: all phases one after the other.
#pragma once

#include <memory>
#include <vector>

#include "bench/isolation/contender.h"
#include "bench/isolation/results.h"
#include "tools/hosts/network.h"

namespace sft::bench::isolation {

struct Scale {
  int rounds = 3;
  double phase_s = 3;  ///< the length of each phase
  double rate_hz = 20;
  bool quick = false;  ///< true: best effort is measured only with SFT
  std::vector<Middleware> middleware{all_middleware.begin(), all_middleware.end()};
};

/// Runs a round, and adds the observations of all phases to `results`. If the programs of one host do not
/// find each other, reports that on the standard error and adds nothing. `network` must have two hosts.
void run_course(const Contender& contender, const std::shared_ptr<const hosts::EmulatedNetwork>& network,
                const Scale& scale, Results& results);

}  // namespace sft::bench::isolation
