#include "bench/common/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sft::bench {

double quantile(std::vector<double>& values, double q) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  const auto rank = static_cast<std::size_t>(std::ceil(q * static_cast<double>(values.size())));
  return values[std::clamp<std::size_t>(rank, 1, values.size()) - 1];
}

double median(std::vector<double> values) { return quantile(values, 0.5); }

double median_if_any(const std::vector<double>& values) {
  return values.empty() ? std::numeric_limits<double>::quiet_NaN() : median(values);
}

void Rounds::add(std::vector<double> times) {
  if (times.empty()) return;
  p50_.push_back(quantile(times, 0.5));
  p99_.push_back(quantile(times, 0.99));
}

double Rounds::p50() const { return median_if_any(p50_); }
double Rounds::p99() const { return median_if_any(p99_); }

}  // namespace sft::bench
