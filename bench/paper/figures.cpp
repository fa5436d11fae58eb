#include "bench/paper/figures.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

namespace sft::bench::paper {

namespace {

struct Comparison {
  const char* suffix;
  Contender ours;
  Contender theirs;
  Metric metric;
  bool has_bound = true;  ///< true: the bound also applies to rows in which only some fields are sent
};

constexpr bool reliable = true, multicast = true;

std::vector<Comparison> comparisons() {
  const Contender recorded{Way::sft_recorded}, declared{Way::sft_declared};
  const Contender cyclone{Way::cyclone}, fast_dds{Way::fast_dds};
  return {{"", recorded, cyclone, received_bytes},
          {"_vs_fast_dds", recorded, fast_dds, received_bytes},
          {"_declared", declared, cyclone, received_bytes},
          {"_reliable", {Way::sft_recorded, reliable}, {Way::cyclone, reliable}, received_bytes},
          {"_sender", recorded, cyclone, sender_bytes},
          {"_sender_multicast",
           {Way::sft_recorded, false, multicast},
           {Way::cyclone, false, multicast},
           sender_bytes,
           false}};
}

Figure bytes_figure(const Records& all, const Row& row, const Comparison& comparison) {
  const Means means = paper::means(all, comparison.ours, comparison.theirs, row.cases, comparison.metric);
  Figure figure{.name = row.name + comparison.suffix,
                .value = means.ours,
                .unit = "B",
                .reference = means.theirs,
                .reference_name = name_of(comparison.theirs)};
  // A peer that lost too many messages in all cases cannot be a reference.
  const bool is_compared = !std::isnan(means.theirs);
  if ((comparison.has_bound || row.sends_all) && is_compared) figure.bound = row.bound;
  return figure;
}

std::string latency_name(const Row& row) {
  const std::string prefix = "bandwidth_";
  return "latency_" + (row.name.starts_with(prefix) ? row.name.substr(prefix.size()) : row.name);
}

/// Returns Cyclone DDS or Fast DDS with the same QoS and network as `ours`, whichever is faster.
Contender better_dds(const Records& all, const Contender& ours, const Cases& cases) {
  const Contender cyclone{Way::cyclone, ours.reliable, ours.multicast};
  const Contender fast_dds{Way::fast_dds, ours.reliable, ours.multicast};
  const double theirs = p50_us(records_of(all, cyclone, cases));
  return std::isnan(theirs) || p50_us(records_of(all, fast_dds, cases)) < theirs ? fast_dds : cyclone;
}

Figure latency_figure(const Records& all, const std::string& name, const Contender& ours,
                      const Cases& cases) {
  const Contender theirs = better_dds(all, ours, cases);
  return {.name = name,
          .value = p50_us(records_of(all, ours, cases)),
          .unit = "us",
          .reference = p50_us(records_of(all, theirs, cases)),
          .reference_name = name_of(theirs),
          .bound = 1};
}

/// Returns the configuration in which SFT is slowest relative to the better DDS.
Figure worst_latency(const Records& all, const std::string& name, const Contender& ours) {
  std::optional<Figure> worst;
  for (const std::string& label : labels(all)) {
    Figure figure = latency_figure(all, name, ours, labelled(label));
    figure.reference_name = name_of(better_dds(all, ours, labelled(label)).way) + ", " + label;
    if (!worst || figure.measure() > worst->measure()) worst = figure;
  }
  return *worst;
}

/// The bytes that receivers got, and the fewest possible bytes with the same fields.
struct Carried {
  double bytes = 0;
  double least = 0;
  double receivers = 0;

  double ratio() const { return bytes / least; }
  double excess() const { return (bytes - least) / receivers; }
};

constexpr double small_bytes_max = 1000;

Carried carried(const Records& records, bool small) {
  Carried sum;
  for (const Record& record : records) {
    for (const Received& receiver : record.receivers) {
      if ((receiver.cdr_bytes <= small_bytes_max) != small) continue;
      sum.bytes += receiver.bytes;
      sum.least += receiver.least_bytes;
      ++sum.receivers;
    }
  }
  return sum;
}

/// The configuration in which samples take the most bytes in relation to the minimum that is possible.
struct Worst {
  std::string label;
  Carried carried;
};
std::optional<Worst> worst_of(const Records& all, const Contender& ours, bool small) {
  std::optional<Worst> worst;
  for (const std::string& label : labels(all)) {
    const Carried one = carried(records_of(all, ours, labelled(label)), small);
    if (one.receivers == 0) continue;
    const bool is_worse =
        !worst || (small ? one.excess() > worst->carried.excess() : one.ratio() > worst->carried.ratio());
    if (is_worse) worst = {label, one};
  }
  return worst;
}

void add_lower_bounds(std::vector<Figure>& to, const Records& all, const std::string& suffix,
                      const Contender& ours) {
  if (const auto large = worst_of(all, ours, false)) {
    to.push_back({.name = "lower_bound_over_1kB" + suffix,
                  .value = large->carried.bytes / large->carried.receivers,
                  .unit = "B",
                  .reference = large->carried.least / large->carried.receivers,
                  .reference_name = large->label,
                  .bound = 1.05});
  }
  if (const auto small = worst_of(all, ours, true)) {
    to.push_back({.name = "lower_bound_excess_to_1kB" + suffix,
                  .value = small->carried.excess(),
                  .unit = "B",
                  .reference_name = small->label,
                  .bound = 40});
  }
}

}  // namespace

std::vector<Figure> row_figures(const Records& all, const std::vector<Row>& rows) {
  std::vector<Figure> figures;
  for (const Row& row : rows) {
    if (std::ranges::none_of(all, [&](const Record& record) { return row.cases(record.of); })) continue;
    for (const Comparison& comparison : comparisons()) figures.push_back(bytes_figure(all, row, comparison));
    figures.push_back(latency_figure(all, latency_name(row), {Way::sft_recorded}, row.cases));
    figures.push_back(
        latency_figure(all, latency_name(row) + "_reliable", {Way::sft_recorded, reliable}, row.cases));
  }
  return figures;
}

std::vector<Figure> configuration_figures(const Records& all) {
  if (all.empty()) return {};
  std::vector<Figure> figures{
      worst_latency(all, "latency_worst", {Way::sft_recorded}),
      worst_latency(all, "latency_worst_reliable", {Way::sft_recorded, reliable}),
      worst_latency(all, "latency_worst_multicast", {Way::sft_recorded, false, multicast})};
  add_lower_bounds(figures, all, "", {Way::sft_recorded});
  add_lower_bounds(figures, all, "_declared", {Way::sft_declared});
  add_lower_bounds(figures, all, "_full", {Way::sft_full});
  add_lower_bounds(figures, all, "_reliable", {Way::sft_recorded, reliable});
  return figures;
}

std::vector<Figure> overhead_figures(const Records& all) {
  const Cases parametric = parametric_rows().front().cases;
  if (records_of(all, {Way::sft_full}, parametric).empty()) return {};
  const Contender full{Way::sft_full};
  const auto overhead = [&](const char* name, const char* unit, Way way, const Metric& metric,
                            double unit_size) {
    const Means both = means(all, {way}, full, parametric, metric);
    return Figure{.name = name,
                  .value = both.ours / unit_size,
                  .unit = unit,
                  .reference = both.theirs / unit_size,
                  .reference_name = name_of(full.way),
                  .bound = 1.01};
  };
  return {overhead("overhead_cpu", "us", Way::sft_recorded, cpu_us, 1),
          overhead("overhead_cpu_declared", "us", Way::sft_declared, cpu_us, 1),
          overhead("overhead_memory", "MB", Way::sft_recorded, resident_bytes, 1e6),
          overhead("overhead_memory_declared", "MB", Way::sft_declared, resident_bytes, 1e6)};
}

}  // namespace sft::bench::paper
