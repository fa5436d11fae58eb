// Conditions on measured values under which a run has failed: "p99 > 2 ms, lost > 0.1 %".
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sft/result.h"

namespace sft::perf {

/// Values by the names that conditions use: times in seconds, `rate` in hertz, and counts. A value that is
/// not known is empty.
using Values = std::map<std::string, std::optional<double>, std::less<>>;

struct Criterion {
  std::string text;  ///< the condition as the user wrote it
  std::string name;
  std::string comparison;    ///< ">", ">=", "<" or "<="
  double bound = 0;          ///< the bound in the unit of the value in Values
  bool of_all_sent = false;  ///< true: the bound is a share of all samples that were sent
};

/// Parses conditions that are separated by commas. An error names the position of the first mistake, and
/// what is allowed there.
Result<std::vector<Criterion>> parse_criteria(std::string_view text);

/// Returns a sentence for each condition that holds. A condition on a value that is not known counts as
/// true, since the value may be bad.
std::vector<std::string> failures(const std::vector<Criterion>& criteria, const Values& values);

}  // namespace sft::perf
