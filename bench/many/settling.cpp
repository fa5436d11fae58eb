#include "bench/many/settling.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sft::bench {

namespace {

constexpr double allowed = 0.05;
constexpr std::size_t window =
    5;  // number of samples in a mean; with so many, control traffic has little influence

double bytes_per_sample(const std::vector<Counted>& samples, std::size_t first, std::size_t last) {
  return static_cast<double>(samples[last].bytes - samples[first].bytes) / static_cast<double>(last - first);
}

}  // namespace

double settled_ms(const std::vector<Counted>& samples, std::int64_t begin_ns) {
  if (samples.size() < 4 * window) return std::numeric_limits<double>::quiet_NaN();
  const double settled = bytes_per_sample(samples, samples.size() / 2, samples.size() - 1);
  std::size_t first = samples.size() - 1 - window;
  while (first > 0 &&
         std::abs(bytes_per_sample(samples, first - 1, first - 1 + window) - settled) <= allowed * settled)
    --first;
  return std::max(0., static_cast<double>(samples[first].at_ns - begin_ns) / 1e6);
}

}  // namespace sft::bench
