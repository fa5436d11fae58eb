#include "bench/paper/comparison.h"

#include <fmt/format.h>

#include <algorithm>

#include "bench/common/statistics.h"

namespace sft::bench::paper {

namespace {

constexpr double lost_max = 0.05;

bool is_same(const Case& a, const Case& b) {
  return a.name == b.name && a.configuration == b.configuration && a.repeat == b.repeat;
}

}  // namespace

double received_bytes(const Record& record) { return record.received_bytes(); }
double sender_bytes(const Record& record) { return record.sender_bytes; }
double cpu_us(const Record& record) { return record.cpu_us; }
double resident_bytes(const Record& record) { return record.resident_bytes; }

Records records_of(const Records& all, const Contender& contender, const Cases& cases) {
  const auto arrived = [](const Received& receiver) { return receiver.lost <= lost_max; };
  Records chosen;
  std::ranges::copy_if(all, std::back_inserter(chosen), [&](const Record& record) {
    return record.contender == contender && cases(record.of) && !record.disturbed &&
           std::ranges::all_of(record.receivers, arrived);
  });
  return chosen;
}

Means means(const Records& all, const Contender& ours, const Contender& theirs, const Cases& cases,
            const Metric& metric) {
  const Records mine = records_of(all, ours, cases), others = records_of(all, theirs, cases);
  Records both_mine, both_others;
  for (const Record& record : mine) {
    const auto other = std::ranges::find_if(
        others, [&](const Record& candidate) { return is_same(candidate.of, record.of); });
    if (other == others.end()) continue;
    both_mine.push_back(record);
    both_others.push_back(*other);
  }
  return {mean(both_mine, metric), mean(both_others, metric)};
}

double mean(const Records& records, const Metric& metric) {
  double sum = 0;
  for (const Record& record : records) sum += metric(record);
  return records.empty() ? unknown : sum / static_cast<double>(records.size());
}

double p50_us(const Records& records) {
  std::vector<double> times;
  for (const Record& record : records) times.push_back(record.p50_us);
  return median_if_any(times);
}

std::string label_of(const Case& of) {
  const Configuration& c = of.configuration;
  if (c.fields == 0) return of.name;
  return fmt::format("{} x {} B, {} receiver{}, {} %", c.fields, c.field_bytes, c.receivers,
                     c.receivers == 1 ? "" : "s", c.percent);
}

std::vector<std::string> labels(const Records& all) {
  std::vector<Case> cases;
  for (const Record& record : all) cases.push_back(record.of);
  std::ranges::stable_sort(cases, {}, &Case::configuration);
  std::vector<std::string> found;
  for (const Case& one : cases) {
    const std::string label = label_of(one);
    if (std::ranges::find(found, label) == found.end()) found.push_back(label);
  }
  return found;
}

Cases labelled(const std::string& label) {
  return [label](const Case& of) { return label_of(of) == label; };
}

}  // namespace sft::bench::paper
