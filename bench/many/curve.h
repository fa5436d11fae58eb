// Costs at several sizes, with the exponents with which they grow, of SFT beside Cyclone DDS.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "bench/common/report.h"
#include "bench/many/tally.h"

namespace sft::bench {

/// The exponent p of the law cost = a * size^p that fits pairs of a size and its cost best: the slope of
/// least squares of their logarithms. Not a number with fewer than two pairs above 0 of different sizes;
/// pairs that are not above 0 do not count.
double exponent(const std::vector<std::pair<double, double>>& costs);

class Curve {
 public:
  struct Cost {
    std::string name;
    std::string unit;
  };

  /// `reference`: what the costs are compared with.
  Curve(std::string name, std::vector<std::size_t> sizes, std::vector<Cost> costs,
        std::string reference = "Cyclone DDS");

  /// Adds a round at one of the sizes. There is a value for each cost, which is not a number if it was not
  /// measured.
  void add_ours(std::size_t size, const std::vector<double>& values);
  void add_reference(std::size_t size, const std::vector<double>& values);

  /// NAME_SIZE_COST, the medians, and NAME_exponent_COST. An exponent is that of the sizes that both
  /// contenders have carried, so that both exponents are of the same range.
  std::vector<Figure> figures() const;
  /// The same figures, a row for each cost and contender, and a column for each size and for the exponent.
  std::string table() const;
  /// Prints the table, and returns the figures.
  std::vector<Figure> report() const;

 private:
  std::size_t index_of(std::size_t size) const;

  std::string name_;
  std::vector<std::size_t> sizes_;
  std::vector<Cost> costs_;
  std::string reference_;
  std::vector<std::vector<Tally>> tallies_;  ///< of each cost, at each size
};

}  // namespace sft::bench
