// Order statistics of measured times.
#pragma once

#include <vector>

namespace sft::bench {

/// The q-quantile (0 to 1) by nearest rank; 0 without values. Sorts `values`.
double quantile(std::vector<double>& values, double q);

/// The median of the results of several rounds, so that one disturbed round does not count.
double median(std::vector<double> values);
/// The median; not a number without values.
double median_if_any(const std::vector<double>& values);

/// Quantiles of a contender that is measured in several rounds. Each quantile is the median over the rounds,
/// and not a number, which is within no bound, if all rounds failed.
class Rounds {
 public:
  void add(std::vector<double> times);
  double p50() const;
  double p99() const;

 private:
  std::vector<double> p50_, p99_;
};

}  // namespace sft::bench
