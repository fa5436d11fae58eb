#include "tools/perf/histogram.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <limits>

namespace sft::perf {

namespace {

constexpr std::uint64_t per_octave = 128;

std::size_t class_of(std::uint64_t value) {
  if (value < per_octave) return value;
  const auto shift = static_cast<std::uint64_t>(std::bit_width(value)) - 8;
  return shift * per_octave + (value >> shift);
}

Histogram::Class bounds_of(std::size_t number, std::uint64_t count) {
  if (number < 2 * per_octave)
    return {static_cast<std::int64_t>(number), static_cast<std::int64_t>(number + 1), count};
  const std::uint64_t shift = number / per_octave - 1;
  const std::uint64_t within = number - shift * per_octave;
  constexpr std::uint64_t largest = std::numeric_limits<std::int64_t>::max();  // the last class ends here
  return {static_cast<std::int64_t>(within << shift),
          static_cast<std::int64_t>(std::min((within + 1) << shift, largest)), count};
}

}  // namespace

void Histogram::add(std::int64_t ns) {
  ns = std::max<std::int64_t>(ns, 0);
  const std::size_t number = class_of(static_cast<std::uint64_t>(ns));
  if (number >= counts_.size()) counts_.resize(number + 1);
  ++counts_[number];
  min_ = count_ == 0 ? ns : std::min(min_, ns);
  max_ = std::max(max_, ns);
  sum_ += static_cast<double>(ns);
  ++count_;
}

std::optional<double> Histogram::min() const {
  return count_ == 0 ? std::nullopt : std::optional(static_cast<double>(min_));
}

std::optional<double> Histogram::max() const {
  return count_ == 0 ? std::nullopt : std::optional(static_cast<double>(max_));
}

std::optional<double> Histogram::mean() const {
  return count_ == 0 ? std::nullopt : std::optional(sum_ / static_cast<double>(count_));
}

std::optional<double> Histogram::percentile(double percent) const {
  const auto values = static_cast<double>(count_);
  constexpr double rounding = 1e-9;
  if (count_ == 0 || values * (100 - percent) / 100 < 1 - rounding) return std::nullopt;
  const auto rank = static_cast<std::uint64_t>(std::max(1.0, std::ceil(values * percent / 100 - rounding)));
  std::uint64_t seen = 0;
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    seen += counts_[i];
    if (seen < rank) continue;
    const Class found = bounds_of(i, counts_[i]);
    const auto middle = static_cast<double>(found.begin + (found.end - found.begin) / 2);
    return std::clamp(middle, static_cast<double>(min_), static_cast<double>(max_));
  }
  return std::nullopt;
}

std::vector<Histogram::Class> Histogram::classes() const {
  std::vector<Class> filled;
  for (std::size_t i = 0; i < counts_.size(); ++i)
    if (counts_[i] != 0) filled.push_back(bounds_of(i, counts_[i]));
  return filled;
}

}  // namespace sft::perf
