// Order statistics of measured times.
#pragma once

#include <vector>

namespace sft::bench {

/// Returns the q-quantile (q from 0 to 1) by nearest rank; 0 if there are no values. Sorts `values`.
double quantile(std::vector<double>& values, double q);

/// Returns the median of the results of several rounds. A single disturbed round does not change it much.
double median(std::vector<double> values);
/// Returns the median; NaN if there are no values.
double median_if_any(const std::vector<double>& values);

/// Quantiles of a contender that is measured in several rounds. Each quantile is the median over the
/// rounds. If all rounds failed, the quantile is NaN, which is within no bound.
class Rounds {
 public:
  void add(std::vector<double> times);
  double p50() const;
  double p99() const;

 private:
  std::vector<double> p50_, p99_;
};

}  // namespace sft::bench
