// The parts of a body that have arrived, as disjoint ranges of bytes in order. While datagrams arrive in
// order, there is a single range.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace sft::udp {

class IntervalSet {
 public:
  struct Interval {
    std::uint32_t begin;
    std::uint32_t end;  ///< the first value after the interval
  };

  /// Adds the interval [begin, end). Returns the number of its bytes that were not in the set before.
  /// REQUIRES: begin < end.
  std::uint32_t add(std::uint32_t begin, std::uint32_t end);

  /// Returns true if adding that interval would increase the number of intervals.
  bool stands_alone(std::uint32_t begin, std::uint32_t end) const;

  std::uint32_t covered() const { return covered_; }
  const std::vector<Interval>& intervals() const { return intervals_; }

  /// Removes all intervals, but keeps the allocated memory.
  void clear() {
    intervals_.clear();
    covered_ = 0;
  }

 private:
  std::vector<Interval> intervals_;  ///< no two intervals overlap or touch
  std::uint32_t covered_ = 0;
};

}  // namespace sft::udp
