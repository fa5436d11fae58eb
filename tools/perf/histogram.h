// A log-linear histogram of times: 128 equal classes for each power of two, so that a percentile is wrong by
// less than 0.4 % however large it is, and memory does not depend on the number of values.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace sft::perf {

class Histogram {
 public:
  /// A negative value counts as 0.
  void add(std::int64_t ns);

  std::uint64_t count() const { return count_; }
  /// Nothing without values.
  std::optional<double> min() const;
  std::optional<double> max() const;
  std::optional<double> mean() const;
  /// Returns the value below which `percent` percent of the values are, by nearest rank. Nothing if there are
  /// too few values to tell: a p99.99 needs 10,000 of them.
  std::optional<double> percentile(double percent) const;

  struct Class {
    std::int64_t begin = 0;  ///< in nanoseconds
    std::int64_t end = 0;
    std::uint64_t count = 0;
  };
  /// Returns the classes that have values, in their order.
  std::vector<Class> classes() const;

 private:
  std::vector<std::uint64_t> counts_;
  std::uint64_t count_ = 0;
  std::int64_t min_ = 0;
  std::int64_t max_ = 0;
  double sum_ = 0;
};

}  // namespace sft::perf
