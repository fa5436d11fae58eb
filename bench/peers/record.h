// The costs of one entrant for messages of one size in one round.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <limits>
#include <vector>

#include "bench/peers/entrant.h"

namespace sft::bench::peers {

inline constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

struct Record {
  std::string group{};  ///< the group of the benchmark that measured the record: "intra_sleeping"
  Case of{};
  Entrant entrant{};
  std::uint32_t bytes = 0;
  std::size_t round = 0;

  std::size_t samples = 0;  ///< the number of messages whose latency is known
  // Quantiles of the time from the writing call until the last reader has the message, in microseconds.
  double p50_us = unknown, p90_us = unknown, p99_us = unknown, p999_us = unknown;
  double paced_cpu_us = unknown;  ///< the CPU time per message, of all processes, while latency is measured
  double per_s = unknown;         ///< messages per second that each reader received
  double fast_cpu_us = unknown;   ///< the CPU time per message, of all processes, at the highest rate
  double lost = unknown;          ///< the share of messages that a reader did not receive
};

using Records = std::vector<Record>;

/// Sets the quantiles. They stay unknown without times.
void set_latency(Record& record, std::vector<double> times_us);

/// The median over the rounds, and their range. All values are unknown if no round has a value.
struct Spread {
  double median = unknown, least = unknown, most = unknown;
};
Spread spread(const std::vector<double>& rounds);

/// Returns the records of one entrant and size in one case.
Records records_of(const Records& all, const Case& of, const Entrant& entrant, std::uint32_t bytes);
/// Returns the spread of a value over the rounds of `records`.
Spread spread(const Records& records, double Record::*value);

/// Writes comma-separated values: a row for each entrant, case, size and round.
void write_csv(std::ostream& out, const Records& all);

}  // namespace sft::bench::peers
