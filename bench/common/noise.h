// How much else the machine did while a benchmark ran.
#pragma once

#include <string>
#include <vector>

#include "bench/common/report.h"

namespace sft::bench {

class Noise {
 public:
  Noise() : begin_(now()) {}

  /// In percent of all processors, since this object was made. Processes that this one has waited for are
  /// parts of the benchmark; a daemon that outlives it is not.
  struct Shares {
    double own = 0, other_programs = 0, other_machines = 0;
  };
  Shares shares() const;

 private:
  /// Seconds of all processors.
  struct Moment {
    double busy_s = 0, stolen_s = 0, all_s = 0, own_s = 0;
  };
  static Moment now();

  const Moment begin_;
};

std::string text_of(const Noise::Shares& shares);
/// For the file with the figures. No change of them makes a benchmark better or worse.
std::vector<Figure> figures_of(const Noise::Shares& shares);

}  // namespace sft::bench
