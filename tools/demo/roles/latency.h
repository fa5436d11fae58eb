// The latencies of one subscriber, and their percentiles.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

namespace sft::demo {

class LatencyRecord {
 public:
  void add(std::chrono::nanoseconds latency) { latencies_ns_.push_back(latency.count()); }

  /// Returns the smallest latency that a share `q` of all latencies does not exceed (nearest rank), in
  /// microseconds; empty while nothing is recorded.
  std::optional<double> percentile_us(double q) const {
    if (latencies_ns_.empty()) return std::nullopt;
    std::vector<std::int64_t> sorted = latencies_ns_;
    const auto count = static_cast<double>(sorted.size());
    const double rank = std::clamp(std::ceil(q * count), 1.0, count);
    const auto nth = sorted.begin() + static_cast<std::ptrdiff_t>(rank) - 1;
    std::nth_element(sorted.begin(), nth, sorted.end());
    return static_cast<double>(*nth) / 1000.0;
  }

 private:
  std::vector<std::int64_t> latencies_ns_;  // an hour at 10 Hz takes 288 kB
};

}  // namespace sft::demo
