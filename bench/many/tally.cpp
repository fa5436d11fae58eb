#include "bench/many/tally.h"

#include <algorithm>
#include <cmath>

#include "bench/common/statistics.h"

namespace sft::bench {

void Tally::add(double value, std::vector<double>& to) {
  if (!std::isnan(value)) to.push_back(value);
}

Figure Tally::figure(const std::string& name, const std::string& unit, const std::string& reference_name,
                     std::optional<double> bound, bool at_least) const {
  Figure figure{.name = name,
                .value = median_if_any(ours_),
                .unit = unit,
                .reference = median_if_any(reference_),
                .reference_name = reference_name,
                .bound = bound,
                .at_least = at_least};
  if (!ours_.empty()) figure.worst = at_least ? std::ranges::min(ours_) : std::ranges::max(ours_);
  return figure;
}

Figure Tally::figure_with_bound_of_value(const std::string& name, const std::string& unit,
                                         const std::string& reference_name, double bound) const {
  Figure figure = this->figure(name, unit, reference_name, bound);
  figure.bound_is_of_value = true;
  return figure;
}

}  // namespace sft::bench
