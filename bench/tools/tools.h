// The groups of this benchmark. Each runs a tool and its reference in turns and returns figures.
#pragma once

#include <vector>

#include "bench/common/report.h"

namespace sft::bench {

struct Scale {
  int rounds = 3;      ///< rounds of each program, in turns; the median is used
  double seconds = 2;  ///< the duration of a round of most programs
};

/// Measures the time that Python adds to a take, to an access to points, and to a loan, with clouds of 6.3
/// MB in shared memory. Also counts the bytes that are copied. Returns nothing if the package was not
/// built.
std::vector<Figure> python(const Scale& scale);
/// Measures the processor time of `sft record`, and its speed of writing.
std::vector<Figure> record(const Scale& scale);
/// Measures by how much the intervals of `sft play` differ from the recorded ones.
std::vector<Figure> play(const Scale& scale);
/// Measures by how much the latency that `sft perf` reports differs from the latency of a small program.
std::vector<Figure> perf(const Scale& scale);

}  // namespace sft::bench
