// Measures operations with Google Benchmark, in turns with copies of memory.
#pragma once

#include <string>
#include <vector>

#include "bench/micro/operation.h"

namespace sft::bench::micro {

struct Scale {
  int repetitions = 41;
  double repetition_s = 0.03;  ///< the minimum length of a repetition of one operation
};

struct Measured {
  std::string name;
  std::size_t copied_bytes = 0;
  std::vector<double> ns;       ///< times of the operation, one per repetition
  std::vector<double> copy_ns;  ///< times of the memcpy, one per repetition
};

/// Measures all operations and the copies, with their repetitions in random order.
std::vector<Measured> measure(const Operations& operations, const Scale& scale);

}  // namespace sft::bench::micro
