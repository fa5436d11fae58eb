// Latencies of one subscriber, and the percentiles of them that people compare.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

namespace sft::demo {

class LatencyRecord {
 public:
  void add(std::chrono::nanoseconds latency) { latencies_ns_.push_back(latency.count()); }

  /// The smallest recorded latency that a share `q` of all does not exceed (nearest rank), in microseconds;
  /// empty while nothing is recorded.
  std::optional<double> percentile_us(double q) const;

 private:
  std::vector<std::int64_t> latencies_ns_;  // 8 bytes a sample: an hour at 10 Hz is 288 kB
};

}  // namespace sft::demo
