// The groups of this benchmark. Each runs SFT and its references in turns, between hosts that it makes
// itself, and returns figures.
#pragma once

#include <cstdint>
#include <vector>

#include "bench/common/report.h"

namespace sft::bench {

struct Scale {
  int rounds = 3;                 ///< rounds of each contender, in turns; the median is used
  double seconds = 1;             ///< the time for which a stream of samples is measured
  std::uint64_t messages = 2000;  ///< number of messages of 64 bytes per round and contender
};

/// Measures the highest rate of reliable samples of 4 MiB, and the processor time per sample.
std::vector<Figure> bulk(const Scale& scale);
/// Measures the round trip of samples of 64 bytes between hosts, for each way of waiting for samples.
std::vector<Figure> small(const Scale& scale);
/// Measures the work of each thread for samples of 64 bytes that are sent from time to time: system calls and
/// wake-ups.
std::vector<Figure> cold_path(const Scale& scale);
/// Measures the highest rate of reliable samples of 64 bytes, published one by one and together.
std::vector<Figure> rate(const Scale& scale);
/// Measures the bytes on the link in addition to those of the samples.
std::vector<Figure> wire_overhead(const Scale& scale);
/// Measures the bytes on the link: per sample of a diagnostic subscriber, and per second of an idle node.
std::vector<Figure> diagnostic_bytes();

}  // namespace sft::bench
