#include "tools/sft/series.h"

#include <algorithm>
#include <cmath>

namespace sft::tool {

void Series::forget_before(Moment when) {
  while (!values_.empty() && values_.front().when < when) values_.pop_front();
}

Spread Series::spread() const {
  if (values_.empty()) return {};
  Spread spread{.count = values_.size(), .min = values_.front().value, .max = values_.front().value};
  for (const Value& v : values_) {
    spread.mean += v.value / static_cast<double>(spread.count);
    spread.min = std::min(spread.min, v.value);
    spread.max = std::max(spread.max, v.value);
  }
  double squares = 0;
  for (const Value& v : values_) squares += (v.value - spread.mean) * (v.value - spread.mean);
  spread.deviation = std::sqrt(squares / static_cast<double>(spread.count));
  return spread;
}

void Periods::add(Moment when) {
  if (latest_ != Moment{}) series_.add(when, std::chrono::duration<double>(when - latest_).count());
  latest_ = when;
}

double Periods::rate() const {
  const double mean = spread().mean;
  return mean > 0 ? 1 / mean : 0;
}

}  // namespace sft::tool
