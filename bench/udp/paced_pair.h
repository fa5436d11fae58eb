// A publisher and a subscriber on two hosts, which sleep between samples. The benchmark does nothing else
// in their processes, so that all their work is for the samples.
#pragma once

#include <sys/types.h>

#include <functional>
#include <optional>

#include "bench/common/contender.h"
#include "bench/common/hosts.h"

namespace sft::bench {

struct Paced {
  Topic topic;
  std::uint64_t messages = 0;
  std::int64_t period_us = 0;  ///< time between two samples
};

struct PacedPair {
  pid_t sender, receiver;
};

/// Calls `begin` when both sides are matched and have passed some samples. Then passes the samples, and calls
/// `end` a period after the last one; without samples, one period after `begin`. The sender's process sleeps
/// once for each sample. Returns false if a sample did not arrive. Between both calls, the threads of both
/// processes and the calling process sleep, except for the samples.
bool pass_paced(Contender contender, const Paced& paced, const TwoHosts& hosts,
                const std::function<void(const PacedPair&)>& begin,
                const std::function<void(const PacedPair&)>& end);

}  // namespace sft::bench
