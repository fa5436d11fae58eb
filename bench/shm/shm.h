// The groups of this benchmark. Each runs SFT and its references in turns and returns figures.
#pragma once

#include <cstdint>
#include <vector>

#include "bench/common/report.h"

namespace sft::bench {

struct Scale {
  std::uint64_t messages = 1600;  ///< number of messages per round and contender
  int rounds = 3;                 ///< rounds of each contender, in turns; the median is used
};

/// Measures the time from publish() of a loan, a 6.3 MB cloud, until the reader has read height and width:
/// for a reader that spins, and for one that sleeps.
std::vector<Figure> hand_over(const Scale& scale);
/// Measures the time with eight sleeping readers: until publish() returns, and until the last reader has
/// read the message.
std::vector<Figure> fan_out(const Scale& scale);
/// Measures the time from before the loan is taken until the sample is read, for clouds of four sizes.
std::vector<Figure> size_flatness(const Scale& scale);

}  // namespace sft::bench
