// The observations of a benchmark, and the tables and figures made from them. Pure: no process is run or read
// here.
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
    1.1;  ///< the maximum ratio of the p99 of local readers to that without the remote reader

class Results {
 public:
  void add(const Contender& contender, Phase phase, Observation observation);

  bool has(const Contender& contender) const;
  /// Returns the summary of all rounds of a phase. REQUIRES: has(contender).
  Summary of(const Contender& contender, Phase phase) const;
  /// Returns the summary of all rounds without a remote reader. REQUIRES: has(contender).
  Summary baseline(const Contender& contender) const;
  /// Returns the delay of each message relative to its planned time.
  std::vector<double> late_us() const;

 private:
  std::map<Contender, std::map<Phase, std::vector<Observation>>> observations_;
};

/// Returns an explanation of the columns of table().
std::string legend();

/// Returns a row for each phase. Each time is followed by its ratio to the time without the remote reader.
std::string table(const Results& results, const Contender& contender);

/// Returns the figures of each disturbance. For SFT these are the p99 of the local readers and of
/// publish(), lost messages and processor time, with the baseline as reference. For other contenders, it is
/// only the p99 of the local readers. A name is "isolation_joined_local_p99"; with best effort it is
/// "isolation_best_effort_joined_local_p99".
std::vector<Figure> figures(const Results& results, bool reliable);

}  // namespace sft::bench::isolation
