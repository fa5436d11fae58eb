// The groups of this benchmark. Each runs a tool and its reference in turns and returns figures.
#pragma once

#include <vector>

#include "bench/common/report.h"

namespace sft::bench {

struct Scale {
  int rounds = 3;      ///< rounds of each program, in turns; the median is used
  double seconds = 2;  ///< the duration of a round of most programs
};

/// Measures what Python adds to a take, to access to points, and to a loan, with clouds of 6.3 MB in shared
/// memory, and counts the bytes that are copied. Returns nothing if the package was not built.
std::vector<Figure> python(const Scale& scale);
/// Measures the processor time of `sft record`, and how fast it writes.
std::vector<Figure> record(const Scale& scale);
/// Measures how well `sft play` keeps the distances of the recorded times.
std::vector<Figure> play(const Scale& scale);
/// Measures by how much the latency that `sft perf` tells differs from the one of a small program.
std::vector<Figure> perf(const Scale& scale);

}  // namespace sft::bench
