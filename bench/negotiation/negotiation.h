// The questions of this benchmark: how fast what was negotiated comes true, and what that costs. Each runs our
// side and its reference in turns and returns figures.
#pragma once

#include <cstdint>
#include <vector>

#include "bench/common/report.h"

namespace sft::bench {

struct Scale {
  std::uint64_t messages = 400;  ///< per round and contender
  int rounds = 3;                ///< of each contender, in turns; the median counts
};

/// What noting that a field was read adds to its getter, after the first access to it in a sample.
std::vector<Figure> getter_overhead(const Scale& scale);

}  // namespace sft::bench
