// The observations of a benchmark, and what it says of them. Pure.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "bench/common/report.h"
#include "bench/isolation/contender.h"
#include "bench/isolation/observation.h"
#include "bench/isolation/phase.h"

namespace sft::bench::isolation {

inline constexpr double local_ratio_max =
    1.1;  ///< of the p99 of local readers to that without the remote one

class Results {
 public:
  void add(const Contender& contender, Phase phase, Observation observation);

  bool has(const Contender& contender) const;
  /// REQUIRES: has(contender).
  Summary of(const Contender& contender, Phase phase) const;
  /// Returns the summary of all rounds without a remote reader. REQUIRES: has(contender).
  Summary baseline(const Contender& contender) const;
  /// How much later than planned publishers ran, for each message.
  std::vector<double> late_us() const;

 private:
  std::map<Contender, std::map<Phase, std::vector<Observation>>> observations_;
};

/// Explains the columns of table().
std::string legend();

/// A line for each phase. Behind each time is its ratio to that without the remote reader.
std::string table(const Results& results, const Contender& contender);

/// For each disturbance the p99 of the local readers and of publish(), lost messages and processor time of
/// SFT, each with the baseline as its reference, and the p99 of the others. "isolation_joined_local_p99" is a
/// name; with best effort it is "isolation_best_effort_joined_local_p99".
std::vector<Figure> figures(const Results& results, bool reliable);

}  // namespace sft::bench::isolation
