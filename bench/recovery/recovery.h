// Measures the time after a hostile act or a fault until every honest pair of programs is served again.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "bench/common/report.h"

namespace sft::bench {

struct RecoveryScale {
  int rounds = 3;                         ///< the number of rounds of each act
  std::chrono::milliseconds length{500};  ///< the duration of an act
  std::string act{};                      ///< the act to perform; empty: all acts
  unsigned long seed = 1;                 ///< the seed of all random numbers
};

/// Returns the median and the worst time for a publisher that is killed by kill -9 and restarted, which is
/// the reference, and for each act.
std::vector<Figure> recovery_after_each_act(const RecoveryScale& scale);

}  // namespace sft::bench
