// How a cost grows.
#pragma once

#include <utility>
#include <vector>

namespace sft::bench {

/// The exponent p of the law cost = a * size^p that fits pairs of a size and its cost best: the slope of
/// least squares of their logarithms. Not a number with fewer than two pairs above 0 of different sizes;
/// pairs that are not above 0 do not count.
double exponent(const std::vector<std::pair<double, double>>& costs);

}  // namespace sft::bench
