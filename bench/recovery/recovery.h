// How long after a hostile act or a mishap every honest pair of programs is served as before.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "bench/common/report.h"

namespace sft::bench {

struct RecoveryScale {
  int rounds = 3;                         ///< of each act
  std::chrono::milliseconds length{500};  ///< of an act
  std::string act{};                      ///< empty: all
  unsigned long seed = 1;                 ///< of all random numbers
};

/// kill -9 of the publisher and its start, as the floor; then each act, p50 and worst.
std::vector<Figure> recovery_after_each_act(const RecoveryScale& scale);

}  // namespace sft::bench
