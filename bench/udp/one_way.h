// Measures the time from write() to the callback for samples that one host sends to another one from time
// to time.
#pragma once

#include <cstdint>
#include <vector>

#include "bench/common/contender.h"
#include "bench/common/hosts.h"

namespace sft::bench {

struct Paced {
  Topic topic;
  std::uint64_t messages = 0;
  std::int64_t period_us = 0;  ///< time between two samples; longer if the previous one has not arrived
};

/// Returns the times at which each sample was written and read, including the first one. Empty if a sample
/// did not arrive.
std::vector<Delivery> one_way_deliveries(Contender contender, const Paced& paced, const TwoHosts& hosts);
/// Returns the times in microseconds, without the first tenth of the samples. Empty if a sample did not
/// arrive.
std::vector<double> one_way_times(Contender contender, const Paced& paced, const TwoHosts& hosts);

}  // namespace sft::bench
