// A log-linear histogram of times. It has 128 equal classes for each power of two, so the error of any
// percentile is less than 0.4 %. Its memory does not depend on the number of values.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace sft::perf {

class Histogram {
 public:
  /// Adds a value. A negative value counts as 0.
  void add(std::int64_t ns);

  std::uint64_t count() const { return count_; }
  /// Return the least and the greatest value; nothing if there are no values.
  std::optional<double> min() const;
  std::optional<double> max() const;
  std::optional<double> mean() const;
  /// Returns the value below which `percent` percent of the values are, by nearest rank. Returns nothing if
  /// there are too few values for this percentile: p99.99 needs 10,000 values.
  std::optional<double> percentile(double percent) const;

  struct Class {
    std::int64_t begin = 0;  ///< the least value of the class in nanoseconds
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
