#include "tools/demo/roles/latency.h"

#include <algorithm>
#include <cmath>

namespace sft::demo {

std::optional<double> LatencyRecord::percentile_us(double q) const {
  if (latencies_ns_.empty()) return std::nullopt;
  std::vector<std::int64_t> sorted = latencies_ns_;
  const auto count = static_cast<double>(sorted.size());
  const double rank = std::clamp(std::ceil(q * count), 1.0, count);
  const auto nth = sorted.begin() + static_cast<std::ptrdiff_t>(rank) - 1;
  std::nth_element(sorted.begin(), nth, sorted.end());
  return static_cast<double>(*nth) / 1000.0;
}

}  // namespace sft::demo
