// The questions of this benchmark. Each runs our side and its references in turns, between hosts that it
// makes itself, and returns figures.
#pragma once

#include <cstdint>
#include <vector>

#include "bench/common/report.h"

namespace sft::bench {

struct Scale {
  int rounds = 3;                 ///< of each contender, in turns; the median counts
  double seconds = 1;             ///< that a stream of samples is watched for
  std::uint64_t messages = 2000;  ///< of 64 bytes, per round and contender; a fiftieth of large ones
};

/// Samples of 4 MiB, reliable, as fast as they can be had, and the processor time that takes.
std::vector<Figure> bulk(const Scale& scale);
/// Samples of 64 bytes from host to host and back, for each way to wait for them.
std::vector<Figure> small(const Scale& scale);
/// Samples of 64 bytes, reliable, as many as can be had: published each by itself, and together.
std::vector<Figure> rate(const Scale& scale);
/// Large samples now and then: from publish to callback.
std::vector<Figure> bulk_latency(const Scale& scale);
/// What leaves the publisher's host for up to eight readers on as many hosts, which ask for one of two masks.
std::vector<Figure> fan_out(const Scale& scale);
/// Bytes on the link against those of the samples.
std::vector<Figure> wire_overhead(const Scale& scale);
/// What reliable delivery says beside the samples, where much is sent and where little is.
std::vector<Figure> ack_overhead(const Scale& scale);

}  // namespace sft::bench
