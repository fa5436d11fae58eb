// The groups of this benchmark. Each runs SFT and its references in turns, between hosts that it makes
// itself, and returns figures.
#pragma once

#include <cstdint>
#include <vector>

#include "bench/common/report.h"

namespace sft::bench {

struct Scale {
  int rounds = 3;                 ///< of each contender, in turns; the median counts
  double seconds = 1;             ///< time for which a stream of samples is measured
  std::uint64_t messages = 2000;  ///< of 64 bytes, per round and contender; a fiftieth of large ones
};

/// The highest rate of reliable samples of 4 MiB, and its processor time.
std::vector<Figure> bulk(const Scale& scale);
/// The round trip of samples of 64 bytes between hosts, for each way to wait for samples.
std::vector<Figure> small(const Scale& scale);
/// What each thread takes for samples of 64 bytes now and then: system calls, wake-ups and, where the machine
/// counts them, instructions and cache misses.
std::vector<Figure> cold_path(const Scale& scale);
/// The highest rate of reliable samples of 64 bytes, published one by one, and together.
std::vector<Figure> rate(const Scale& scale);
/// The time from publish to callback of large samples that are sent now and then.
std::vector<Figure> bulk_latency(const Scale& scale);
/// The worst times from publish to callback of samples of 6.3 MB that are sent each 100 ms, the first one
/// among them.
std::vector<Figure> worst(const Scale& scale);
/// The bytes that leave the publisher's host for up to eight readers on as many hosts, which ask for one of
/// two masks.
std::vector<Figure> fan_out(const Scale& scale);
/// The bytes on the link beside those of the samples.
std::vector<Figure> wire_overhead(const Scale& scale);
/// The control traffic of reliable delivery beside the samples, with much and with little data.
std::vector<Figure> ack_overhead(const Scale& scale);

}  // namespace sft::bench
