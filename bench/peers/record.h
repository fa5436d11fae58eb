// What one entrant took for messages of one size in one round.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <limits>
#include <vector>

#include "bench/peers/entrant.h"

namespace sft::bench::peers {

inline constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

struct Record {
  std::string group{};  ///< the group of the benchmark that measured it: "intra_sleeping"
  Case of{};
  Entrant entrant{};
  std::uint32_t bytes = 0;
  std::size_t round = 0;

  std::size_t samples = 0;  ///< messages whose latency is known
  // In us, from the call until the last reader has the message:
  double p50_us = unknown, p90_us = unknown, p99_us = unknown, p999_us = unknown;
  double paced_cpu_us = unknown;  ///< of a message, all processes, at the pace of latency
  double per_s = unknown;         ///< messages that each reader got in a second
  double fast_cpu_us = unknown;   ///< of such a message, all processes
  double lost = unknown;          ///< the share of messages that a reader did not get
};

using Records = std::vector<Record>;

/// Fills in the quantiles. Leaves them unknown without times.
void set_latency(Record& record, std::vector<double> times_us);

/// The median over the rounds, and their range. All are unknown if no round has a value.
struct Spread {
  double median = unknown, least = unknown, most = unknown;
};
Spread spread(const std::vector<double>& rounds);

/// The records of one entrant and size in one case.
Records records_of(const Records& all, const Case& of, const Entrant& entrant, std::uint32_t bytes);
/// The spread of a value over the rounds of `records`.
Spread spread(const Records& records, double Record::*value);

/// Comma-separated values: one line for each entrant, case, size and round.
void write_csv(std::ostream& out, const Records& all);

}  // namespace sft::bench::peers
