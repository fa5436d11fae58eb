// Measures how long after a hostile act or a mishap every honest pair of programs is served as before.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "bench/common/report.h"

namespace sft::bench {

struct RecoveryScale {
  int rounds = 3;                         ///< of each act
  std::chrono::milliseconds length{500};  ///< of an act
  std::string act{};                      ///< the act to perform; empty: all acts
  unsigned long seed = 1;                 ///< of all random numbers
};

/// First kill -9 of the publisher and its new start, as the floor, then each act: median and worst case.
std::vector<Figure> recovery_after_each_act(const RecoveryScale& scale);

}  // namespace sft::bench
