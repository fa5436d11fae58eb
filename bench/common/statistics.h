// Order statistics of measured times.
#pragma once

#include <vector>

namespace sft::bench {

/// The q-quantile (0 to 1) by nearest rank; 0 of nothing. Sorts `values`.
double quantile(std::vector<double>& values, double q);

/// The median of several rounds' results: one disturbed round does not count.
double median(std::vector<double> values);
/// Not a number of nothing.
double median_if_any(const std::vector<double>& values);

/// Quantiles of a contender that is measured in several rounds, each as the median over these. Not a number
/// if it failed in all of them, which is within no bound.
class Rounds {
 public:
  void add(std::vector<double> times);
  double p50() const;
  double p99() const;

 private:
  std::vector<double> p50_, p99_;
};

}  // namespace sft::bench
