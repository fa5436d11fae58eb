#include "bench/micro/change.h"

#include <fmt/format.h>

#include <algorithm>
#include <istream>
#include <nlohmann/json.hpp>
#include <ostream>
#include <set>

namespace sft::bench::micro {

namespace {

/// The rank k, so that the true median is between the k-th smallest and the k-th largest of so many values in
/// 99 % of cases; 1 if there is none.
std::size_t sign_test_rank(std::size_t values) {
  constexpr double error = 0.01;
  double probability = 1;  // of exactly `rank` values below the median, of all cases
  for (std::size_t i = 0; i < values; ++i) probability /= 2;
  double below = 0;
  std::size_t rank = 0;
  while (rank < values) {
    below += probability;
    if (2 * below > error) break;
    ++rank;
    probability *= static_cast<double>(values - rank + 1) / static_cast<double>(rank);
  }
  return std::max<std::size_t>(rank, 1);
}

Verdict verdict(const Interval& before, const Interval& now) {
  if (now.low > before.high && now.middle > before.middle * (1 + change_min)) return Verdict::slower;
  if (now.high < before.low && now.middle < before.middle * (1 - change_min)) return Verdict::faster;
  return Verdict::same;
}

const char* word_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::slower:
      return "slower";
    case Verdict::faster:
      return "faster";
    case Verdict::same:
      return "same";
    case Verdict::only_before:
      return "not measured now";
    case Verdict::only_now:
      break;
  }
  return "not kept before";
}

std::string interval_text(const Interval& interval) {
  return fmt::format("{:.3f} [{:.3f}, {:.3f}]", interval.middle, interval.low, interval.high);
}

std::string line(const Change& change) {
  const bool both = change.verdict != Verdict::only_before && change.verdict != Verdict::only_now;
  return fmt::format(
      "{:<36} {:>26} {:>26} {:>9} {}\n", change.name,
      change.verdict == Verdict::only_now ? "" : interval_text(change.before),
      change.verdict == Verdict::only_before ? "" : interval_text(change.now),
      both ? fmt::format("{:+.1f} %", 100 * (change.now.middle / change.before.middle - 1)) : "",
      word_of(change.verdict));
}

}  // namespace

Interval interval_of(std::vector<double> ratios) {
  std::ranges::sort(ratios);
  const std::size_t rank = sign_test_rank(ratios.size());
  const std::size_t half = ratios.size() / 2;
  const double middle = ratios.size() % 2 == 1 ? ratios[half] : (ratios[half - 1] + ratios[half]) / 2;
  return {ratios[rank - 1], middle, ratios[ratios.size() - rank]};
}

std::vector<Change> compare(const Ratios& before, const Ratios& now) {
  std::set<std::string> names;
  for (const Ratios* ratios : {&before, &now}) {
    for (const auto& [name, values] : *ratios) names.insert(name);
  }
  std::vector<Change> changes;
  for (const std::string& name : names) {
    Change change{.name = name};
    if (before.contains(name)) change.before = interval_of(before.at(name));
    if (now.contains(name)) change.now = interval_of(now.at(name));
    if (!now.contains(name)) {
      change.verdict = Verdict::only_before;
    } else if (!before.contains(name)) {
      change.verdict = Verdict::only_now;
    } else {
      change.verdict = verdict(change.before, change.now);
    }
    changes.push_back(std::move(change));
  }
  return changes;
}

std::string text_of(const std::vector<Change>& changes) {
  std::string text = fmt::format("{:<36} {:>26} {:>26} {:>9}\n", "ratio to memcpy [99 % interval]",
                                 "kept baseline", "now", "change");
  for (const Change& change : changes) text += line(change);
  const auto count = [&](Verdict verdict) { return std::ranges::count(changes, verdict, &Change::verdict); };
  return text + fmt::format("{} slower, {} faster, {} the same within noise and {:.0f} %.\n",
                            count(Verdict::slower), count(Verdict::faster), count(Verdict::same),
                            100 * change_min);
}

void write(std::ostream& out, const Ratios& ratios) { out << nlohmann::json(ratios).dump(1) << std::endl; }

Ratios read(std::istream& in) {
  const nlohmann::json json = nlohmann::json::parse(in, nullptr, false);
  if (!json.is_object()) return {};
  Ratios ratios;
  for (const auto& [name, values] : json.items()) {
    const bool numbers = values.is_array() && !values.empty() &&
                         std::ranges::all_of(values, [](const auto& value) { return value.is_number(); });
    if (!numbers) return {};
    ratios[name] = values.template get<std::vector<double>>();
  }
  return ratios;
}

}  // namespace sft::bench::micro
