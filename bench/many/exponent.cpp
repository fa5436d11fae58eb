#include "bench/many/exponent.h"

#include <cmath>
#include <limits>

namespace sft::bench {

double exponent(const std::vector<std::pair<double, double>>& costs) {
  double count = 0, x_sum = 0, y_sum = 0, xx_sum = 0, xy_sum = 0;
  for (const auto& [size, cost] : costs) {
    if (!(size > 0 && cost > 0)) continue;
    const double x = std::log(size), y = std::log(cost);
    ++count;
    x_sum += x;
    y_sum += y;
    xx_sum += x * x;
    xy_sum += x * y;
  }
  const double spread = count * xx_sum - x_sum * x_sum;
  if (spread <= 0) return std::numeric_limits<double>::quiet_NaN();
  return (count * xy_sum - x_sum * y_sum) / spread;
}

}  // namespace sft::bench
