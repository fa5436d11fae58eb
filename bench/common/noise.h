// How much else the machine did while a benchmark ran.
#pragma once

#include <string>

namespace sft::bench {

class Noise {
 public:
  Noise() : begin_(now()) {}

  /// A sentence about the time since this object was made. It counts the processes that this one has waited
  /// for as parts of the benchmark.
  std::string text() const;

 private:
  /// Seconds of all processors.
  struct Moment {
    double busy_s = 0, stolen_s = 0, all_s = 0, own_s = 0;
  };
  static Moment now();

  const Moment begin_;
};

}  // namespace sft::bench
