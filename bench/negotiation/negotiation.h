// The groups of this benchmark: how soon the result of a negotiation takes effect, and its costs. Each group
// runs SFT and its reference in turns and returns figures.
#pragma once

#include <cstdint>
#include <vector>

#include "bench/common/report.h"

namespace sft::bench {

struct Scale {
  std::uint64_t messages = 400;     ///< number of messages per round and contender
  int rounds = 3;                   ///< rounds of each contender, in turns; the median is used
  int starts = 25;                  ///< number of starts of new nodes, for each contender and case
  std::uint64_t late_readers = 50;  ///< number of late readers per round and contender
};

/// Measures the time from the getter call that widens the mask until the publisher on another host has
/// applied the mask.
std::vector<Figure> str_response(const Scale& scale);
/// Measures the time from before a node opens to the first sample of a publisher on another host.
std::vector<Figure> first_sample_new_nodes(const Scale& scale);
/// Measures the time from before a node subscribes until the first sample. The publisher's node already
/// knows the subscriber's node.
std::vector<Figure> first_sample_late_reader(const Scale& scale);

}  // namespace sft::bench
