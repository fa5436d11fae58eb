// Compares contenders by their records of the same cases. Pure functions.
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

/// A set of cases, as a predicate: for example, all configurations with one probability.
using Cases = std::function<bool(const Case&)>;

/// Returns the undisturbed records of a contender. Records in which more than a twentieth of the messages
/// were lost are left out, since lost messages take no bytes.
Records records_of(const Records& all, const Contender& contender, const Cases& cases);

/// The means over the cases of which both contenders have a record; unknown if there are no such cases.
struct Means {
  double ours = unknown;
  double theirs = unknown;
};
Means means(const Records& all, const Contender& ours, const Contender& theirs, const Cases& cases,
            const Metric& metric);

/// Returns the mean; unknown if there are no records.
double mean(const Records& records, const Metric& metric);

/// Returns the median of the medians in the records.
double p50_us(const Records& records);

/// Returns the name of a case, the same for all its repeats. For a configuration it is "5 x 128 B, 3
/// receivers, 50 %".
std::string label_of(const Case& of);
/// Returns the names of all cases in the order of their configurations, each once.
std::vector<std::string> labels(const Records& all);
Cases labelled(const std::string& label);

}  // namespace sft::bench::paper
