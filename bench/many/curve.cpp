#include "bench/many/curve.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

namespace sft::bench {

namespace {

/// The unit of exponents. Costs that do not grow have exponents near 0, for which a ratio or a bar has no
/// meaning.
constexpr const char* unit_of_exponents = "exponent";

std::string cell(double value) { return fmt::format(" {:>13.{}f}", value, std::abs(value) < 100 ? 2 : 0); }

}  // namespace

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

Curve::Curve(std::string name, std::vector<std::size_t> sizes, std::vector<Cost> costs, std::string reference)
    : name_(std::move(name)),
      sizes_(std::move(sizes)),
      costs_(std::move(costs)),
      reference_(std::move(reference)),
      tallies_(costs_.size(), std::vector<Tally>(sizes_.size())) {}

std::size_t Curve::index_of(std::size_t size) const {
  return static_cast<std::size_t>(std::ranges::find(sizes_, size) - sizes_.begin());
}

void Curve::add_ours(std::size_t size, const std::vector<double>& values) {
  for (std::size_t cost = 0; cost < costs_.size(); ++cost)
    tallies_[cost][index_of(size)].add_ours(values[cost]);
}

void Curve::add_reference(std::size_t size, const std::vector<double>& values) {
  for (std::size_t cost = 0; cost < costs_.size(); ++cost)
    tallies_[cost][index_of(size)].add_reference(values[cost]);
}

std::vector<Figure> Curve::figures() const {
  std::vector<Figure> figures;
  for (std::size_t cost = 0; cost < costs_.size(); ++cost) {
    const auto& [cost_name, unit] = costs_[cost];
    std::vector<std::pair<double, double>> ours, theirs;
    for (std::size_t i = 0; i < sizes_.size(); ++i) {
      const std::string name = fmt::format("{}_{}_{}", name_, sizes_[i], cost_name);
      figures.push_back(tallies_[cost][i].figure(name, unit, reference_, {}));
      const double value = figures.back().value, reference = *figures.back().reference;
      if (!std::isfinite(value) || !std::isfinite(reference)) continue;
      ours.emplace_back(sizes_[i], value);
      theirs.emplace_back(sizes_[i], reference);
    }
    figures.push_back({fmt::format("{}_exponent_{}", name_, cost_name), exponent(ours), unit_of_exponents,
                       exponent(theirs), "that of " + reference_});
  }
  return figures;
}

std::string Curve::table() const {
  const std::vector<Figure> figures = this->figures();
  std::string text = fmt::format("\n{:<36}", name_);
  for (const std::size_t size : sizes_) text += fmt::format(" {:>13}", size);
  text += fmt::format(" {:>13}\n", "exponent");
  auto figure = figures.begin();
  for (const Cost& cost : costs_) {
    std::string ours, theirs;
    for (std::size_t i = 0; i <= sizes_.size(); ++i, ++figure) {
      ours += cell(figure->value);
      theirs += cell(*figure->reference);
    }
    text += fmt::format("{:<23}{:<13}{}\n{:<23}{:<13}{}\n", fmt::format("{}, {}", cost.name, cost.unit),
                        "SFT", ours, "", reference_, theirs);
  }
  return text;
}

std::vector<Figure> Curve::report() const {
  fmt::print("{}", table());
  std::fflush(stdout);  // otherwise processes that are forked later would print it again
  return figures();
}

}  // namespace sft::bench
