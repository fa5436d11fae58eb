// Statistics of values that were measured in the last few seconds.
#pragma once

#include <chrono>
#include <cstddef>
#include <deque>

namespace sft::tool {

/// A time of a monotonic clock, so that the time between two events is never negative.
using Moment = std::chrono::steady_clock::time_point;

struct Spread {
  std::size_t count = 0;
  double mean = 0;
  double min = 0;
  double max = 0;
  double deviation = 0;  ///< standard deviation
};

class Series {
 public:
  void add(Moment when, double value) { values_.push_back({when, value}); }
  /// Removes values that are older than `when`.
  void forget_before(Moment when);
  Spread spread() const;

 private:
  struct Value {
    Moment when;
    double value;
  };
  std::deque<Value> values_;
};

/// The times between events, in seconds.
class Periods {
 public:
  void add(Moment when);
  void forget_before(Moment when) { series_.forget_before(when); }
  Spread spread() const { return series_.spread(); }
  /// Returns the number of events per second, or 0 before the second event.
  double rate() const;

 private:
  Series series_;
  Moment latest_{};
};

}  // namespace sft::tool
