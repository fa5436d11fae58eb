// A publisher and a subscriber on two hosts, which sleep between samples. Nothing else of the benchmark runs
// in their processes, so that what they take is what the samples take.
#pragma once

#include <sys/types.h>

#include <functional>
#include <optional>

#include "bench/udp/one_way.h"

namespace sft::bench {

struct PacedPair {
  pid_t sender, receiver;
};

/// Calls `begin` when both sides are matched and have passed some samples. Then passes the samples, of which
/// the sender's process takes a sleep each, and calls `end` a period after the last one; without samples, one
/// period after `begin`. Returns false if a sample did not arrive. Between both calls the threads of both
/// processes sleep but for the samples, and the process that calls this sleeps, too.
bool pass_paced(Contender contender, const Paced& paced, const TwoHosts& hosts,
                const std::function<void(const PacedPair&)>& begin,
                const std::function<void(const PacedPair&)>& end);

/// Processor time in microseconds of a sample, of both processes, with what they do anyway. Not a number if a
/// sample did not arrive.
double paced_cpu_us(Contender contender, const Paced& paced, const TwoHosts& hosts);

}  // namespace sft::bench
