// The results of one figure over several rounds.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bench/common/report.h"

namespace sft::bench {

class Tally {
 public:
  // The following functions ignore NaN, the result of a round that failed.
  void add_ours(double value) { add(value, ours_); }
  void add_reference(double value) { add(value, reference_); }

  /// Returns the medians, and the worst round, which is the largest value or, with `at_least`, the smallest
  /// one.
  Figure figure(const std::string& name, const std::string& unit, const std::string& reference_name,
                std::optional<double> bound, bool at_least = false) const;
  /// Returns the figure with a bound for its value, and not for its ratio.
  Figure figure_with_bound_of_value(const std::string& name, const std::string& unit,
                                    const std::string& reference_name, double bound) const;

 private:
  static void add(double value, std::vector<double>& to);

  std::vector<double> ours_, reference_;
};

}  // namespace sft::bench
