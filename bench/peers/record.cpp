#include "bench/peers/record.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <ostream>

#include "bench/common/statistics.h"

namespace sft::bench::peers {

void set_latency(Record& record, std::vector<double> times_us) {
  record.samples = times_us.size();
  if (times_us.empty()) return;
  record.p50_us = quantile(times_us, 0.5);
  record.p90_us = quantile(times_us, 0.9);
  record.p99_us = quantile(times_us, 0.99);
  record.p999_us = quantile(times_us, 0.999);
}

Spread spread(const std::vector<double>& rounds) {
  std::vector<double> known;
  std::ranges::copy_if(rounds, std::back_inserter(known), [](double value) { return std::isfinite(value); });
  if (known.empty()) return {};
  const auto [least, most] = std::ranges::minmax(known);
  return {median(known), least, most};
}

Records records_of(const Records& all, const Case& of, const Entrant& entrant, std::uint32_t bytes) {
  Records records;
  std::ranges::copy_if(all, std::back_inserter(records), [&](const Record& record) {
    return record.of == of && record.entrant == entrant && record.bytes == bytes;
  });
  return records;
}

Spread spread(const Records& records, double Record::*value) {
  std::vector<double> rounds;
  for (const Record& record : records) rounds.push_back(record.*value);
  return spread(rounds);
}

void write_csv(std::ostream& out, const Records& all) {
  out << "group,where,waiting,readers,contender,bytes,round,samples,p50_us,p90_us,p99_us,p999_us,paced_cpu_"
         "us,"
         "messages_per_s,fast_cpu_us,lost_share\n";
  for (const Record& r : all) {
    out << fmt::format("{},{},{},{},{},{},{},{},{:.2f},{:.2f},{:.2f},{:.2f},{:.2f},{:.1f},{:.2f},{:.4f}\n",
                       r.group, r.of.where == Where::one_host ? "one_host" : "two_hosts",
                       r.of.waiting == Waiting::sleeping ? "sleeping" : "spinning", r.of.readers,
                       id_of(r.entrant), r.bytes, r.round + 1, r.samples, r.p50_us, r.p90_us, r.p99_us,
                       r.p999_us, r.paced_cpu_us, r.per_s, r.fast_cpu_us, r.lost);
  }
  out << std::flush;  // needed because an isolated program ends without destroying the stream
}

}  // namespace sft::bench::peers
