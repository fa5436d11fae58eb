// The costs of SFT at several sizes compared with Cyclone DDS, and the exponents with which they grow.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "bench/common/report.h"
#include "bench/many/tally.h"

namespace sft::bench {

/// Returns the exponent p of the law cost = a * size^p that fits the pairs of size and cost best, which is
/// the slope of least squares of their logarithms. Pairs with a number that is not above 0 are ignored.
/// Returns NaN if fewer than two pairs of different sizes remain.
double exponent(const std::vector<std::pair<double, double>>& costs);

class Curve {
 public:
  struct Cost {
    std::string name;
    std::string unit;
  };

  /// `reference` is the name of the contender with which the costs are compared.
  Curve(std::string name, std::vector<std::size_t> sizes, std::vector<Cost> costs,
        std::string reference = "Cyclone DDS");

  /// Adds a round at one of the sizes. `values` has a value for each cost; NaN if the cost was not
  /// measured.
  void add_ours(std::size_t size, const std::vector<double>& values);
  void add_reference(std::size_t size, const std::vector<double>& values);

  /// Returns the medians, NAME_SIZE_COST, and the exponents, NAME_exponent_COST. Exponents are computed
  /// from the sizes for which both contenders have results, so that both exponents have the same range.
  std::vector<Figure> figures() const;
  /// Returns the figures as a table. It has a row for each cost and contender, and a column for each size
  /// and for the exponent.
  std::string table() const;
  /// Prints the table, and returns the figures.
  std::vector<Figure> report() const;

 private:
  std::size_t index_of(std::size_t size) const;

  std::string name_;
  std::vector<std::size_t> sizes_;
  std::vector<Cost> costs_;
  std::string reference_;
  std::vector<std::vector<Tally>> tallies_;  ///< one tally for each cost and each size
};

}  // namespace sft::bench
