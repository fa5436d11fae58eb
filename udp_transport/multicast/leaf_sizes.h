// The average sizes of the fields in the samples of one writer: the number of elements of sequences, and the
// length of strings. The length of a body under any mask is computed from these averages.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "sft/detail/walk.h"

namespace sft::udp {

class LeafSizes {
 public:
  /// `type` must outlive this object.
  explicit LeafSizes(const StructType& type);

  /// Measures the fields in the sample, but only the first elements of a collection of structs. Must be
  /// called by only one thread. The values of a new sample get a weight of one quarter in the averages.
  /// Allocates nothing.
  void measure(const detail::SampleState& sample) noexcept;

  // Any thread may call the following functions.

  /// Returns true if each of these fields has been measured, or has a fixed size.
  bool known(const FieldMask& fields) const;
  /// Returns the length in bytes of a body with exactly these fields. `fields` must be a closed mask
  /// (TypeSupport::closed()).
  double bytes(const FieldMask& fields) const;

 private:
  static constexpr std::uint32_t elements_max = 32;  ///< maximum number of measured elements

  /// The average over the samples so far. `sum` and `count` are the values of the sample that is being
  /// measured.
  struct Average {
    std::atomic<double> value{unmeasured};
    std::uint64_t sum = 0, count = 0;
  };
  static constexpr double unmeasured = -1;

  class Meter;
  class Sum;
  static double value_of(const Average& average);
  static void settle(Average& average);
  void find_variable(const StructType& type, std::size_t& leaf);

  const StructType& type_;
  const std::size_t leaves_;
  std::unique_ptr<Average[]> elements_;  ///< by leaf: average number of elements of a sequence
  std::unique_ptr<Average[]> strings_;   ///< by leaf: average bytes of a string, with its NUL
  /// The leaves with an average in `elements_`, and those with one in `strings_`.
  FieldMask sequences_, texts_;
};

}  // namespace sft::udp
