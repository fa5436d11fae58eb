// The groups of this benchmark. Each runs SFT and its reference in turns and returns figures.
#pragma once

#include <cstdint>
#include <vector>

#include "bench/common/report.h"

namespace sft::bench {

struct Scale {
  std::uint64_t messages = 4000;  ///< number of messages in each round
  int rounds = 3;                 ///< rounds of each contender, in turns; the median is used
};

/// Measures the time in shared memory from publish() of a loan, a 6.3 MB point cloud, until the reader has
/// read height() and width(): for a reader that sleeps, and for one that spins.
std::vector<Figure> shared_memory(const Scale& scale);
/// Measures the time of 64 bytes of fields between two hosts, from callback to callback, compared with
/// blocking sockets.
std::vector<Figure> udp_small(const Scale& scale);
/// Measures the bytes on the link: per sample of a diagnostic subscriber, and per second of an idle node.
std::vector<Figure> wire_bytes();

}  // namespace sft::bench
