// Order statistics of measured times.
#pragma once

#include <vector>

namespace sft::bench {

/// The q-quantile (0 to 1) by nearest rank; 0 of nothing. Sorts `values`.
double quantile(std::vector<double>& values, double q);

/// The median of several rounds' results: one disturbed round does not count.
double median(std::vector<double> values);

}  // namespace sft::bench
