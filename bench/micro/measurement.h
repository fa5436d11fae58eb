// Times operations with Google Benchmark, in turns with copies of memory.
#pragma once

#include <string>
#include <vector>

#include "bench/micro/operation.h"

namespace sft::bench::micro {

struct Scale {
  int repetitions = 41;
  double repetition_s = 0.03;  ///< the least length of a repetition of one operation
};

struct Measured {
  std::string name;
  std::size_t copied_bytes = 0;
  std::vector<double> ns;       ///< of the operation, by repetition
  std::vector<double> copy_ns;  ///< of the memcpy, by repetition
};

/// Repetitions of all operations, and of the copies, come in random order.
std::vector<Measured> measure(const Operations& operations, const Scale& scale);

}  // namespace sft::bench::micro
