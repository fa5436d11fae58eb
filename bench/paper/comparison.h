// Compares contenders by the records of the same cases. Pure functions.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "bench/paper/record.h"

namespace sft::bench::paper {

using Records = std::vector<Record>;
using Metric = std::function<double(const Record&)>;

double received_bytes(const Record& record);
double sender_bytes(const Record& record);
double cpu_us(const Record& record);
double resident_bytes(const Record& record);

/// Some cases, such as all configurations with one probability.
using Cases = std::function<bool(const Case&)>;

/// The records of a contender that are not disturbed. Those in which more than a twentieth of the messages
/// were lost are not among them, since lost messages take no bytes.
Records records_of(const Records& all, const Contender& contender, const Cases& cases);

/// Means over the cases of which both contenders have a record; unknown if there are none.
struct Means {
  double ours = unknown;
  double theirs = unknown;
};
Means means(const Records& all, const Contender& ours, const Contender& theirs, const Cases& cases,
            const Metric& metric);

/// The mean and the standard deviation; both unknown if there are no records.
struct Spread {
  double mean = unknown;
  double deviation = unknown;
};
Spread spread(const Records& records, const Metric& metric);

/// The median of the records' medians.
double p50_us(const Records& records);

/// The name of a case, with all its repeats; that of a configuration is "5 x 128 B, 3 receivers, 50 %".
std::string label_of(const Case& of);
/// The names of all cases, in the order of their configurations, each of them once.
std::vector<std::string> labels(const Records& all);
Cases labelled(const std::string& label);

}  // namespace sft::bench::paper
