// The groups of this benchmark. Each runs SFT and its references in turns and returns figures.
#pragma once

#include <cstdint>
#include <vector>

#include "bench/common/report.h"

namespace sft::bench {

struct Scale {
  /// Number of messages per round and contender. If whole clouds are copied, only an eighth of it is sent.
  std::uint64_t messages = 1600;
  int rounds = 3;      ///< rounds of each contender, in turns; the median is used
  double idle_s = 10;  ///< the time for which a waiting node is observed
};

/// Measures the time from publish() of a loan, a 6.3 MB cloud, until the reader has read height and width:
/// for a reader that spins, and for one that sleeps.
std::vector<Figure> hand_over(const Scale& scale);
/// Measures the time from before publish() of a small message in the memory of the program until a sleeping
/// reader has taken the message.
std::vector<Figure> messages(const Scale& scale);
/// Measures the time with eight sleeping readers: until publish() returns, and until the last reader has
/// read the message.
std::vector<Figure> fan_out(const Scale& scale);
/// Measures the time of the same cloud with Cyclone DDS and Fast DDS.
std::vector<Figure> clouds(const Scale& scale);
/// Measures the time from before the loan is taken until the sample is read, for clouds of four sizes.
std::vector<Figure> size_flatness(const Scale& scale);
/// Measures the processor time of a node that waits for samples while none arrive.
std::vector<Figure> idle_cpu(const Scale& scale);

}  // namespace sft::bench
