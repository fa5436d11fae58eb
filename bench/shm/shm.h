// The questions of this benchmark. Each runs our side and its references in turns and returns figures.
#pragma once

#include <cstdint>
#include <vector>

#include "bench/common/report.h"

namespace sft::bench {

struct Scale {
  std::uint64_t messages = 1600;  ///< per round and contender; an eighth where whole clouds are copied
  int rounds = 3;                 ///< of each contender, in turns; the median counts
  double idle_s = 10;             ///< how long a node is watched while it waits
};

/// A 6.3 MB cloud from publish of a loan to its height and width read: reader spinning, reader asleep.
std::vector<Figure> hand_over(const Scale& scale);
/// Eight readers asleep: until publish() returns, and until the last of them has read.
std::vector<Figure> fan_out(const Scale& scale);
/// The same cloud with Cyclone DDS and Fast DDS.
std::vector<Figure> clouds(const Scale& scale);
/// From before the loan is taken to the sample read, for clouds of four sizes.
std::vector<Figure> size_flatness(const Scale& scale);
/// Of a node that waits for samples which do not come.
std::vector<Figure> idle_cpu(const Scale& scale);

}  // namespace sft::bench
