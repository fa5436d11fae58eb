// The questions of this benchmark. Each runs our side and its reference in turns and returns figures.
#pragma once

#include <cstdint>
#include <vector>

#include "bench/common/report.h"

namespace sft::bench {

struct Scale {
  std::uint64_t messages = 4000;  ///< per round
  int rounds = 3;                 ///< of each contender, in turns; the median counts
};

/// A 6.3 MB point cloud, from publish of a loan to height() and width() read, in shared memory: reader
/// asleep, reader spinning.
std::vector<Figure> shared_memory(const Scale& scale);
/// 64 bytes of fields between two hosts, callback to callback, against blocking sockets.
std::vector<Figure> udp_small(const Scale& scale);
/// Bytes on the link: of a diagnostic subscriber per sample, and of an idle node per second.
std::vector<Figure> wire_bytes();

}  // namespace sft::bench
