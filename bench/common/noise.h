// Measures how much other work the machine did while a benchmark ran.
#pragma once

#include <string>
#include <vector>

#include "bench/common/report.h"

namespace sft::bench {

class Noise {
 public:
  Noise() : begin_(now()) {}

  /// Shares of the time of all processors since the object of class Noise was made, in percent. A child
  /// process counts as `own` once this process has waited for its end. A daemon that outlives this process
  /// does not count as `own`.
  struct Shares {
    double own = 0, other_programs = 0, other_machines = 0;
  };
  Shares shares() const;

 private:
  /// Sums over all processors at one moment, in seconds.
  struct Moment {
    double busy_s = 0, stolen_s = 0, all_s = 0, own_s = 0;
  };
  static Moment now();

  const Moment begin_;
};

std::string text_of(const Noise::Shares& shares);
/// Returns the shares as figures for the file. A change of these figures makes no benchmark better or
/// worse.
std::vector<Figure> figures_of(const Noise::Shares& shares);

}  // namespace sft::bench
