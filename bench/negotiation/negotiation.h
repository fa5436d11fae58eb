// The groups of this benchmark: how fast the result of a negotiation takes effect, and how much that costs.
// Each runs SFT and its reference in turns and returns figures.
#pragma once

#include <cstdint>
#include <vector>

#include "bench/common/report.h"

namespace sft::bench {

struct Scale {
  std::uint64_t messages = 400;     ///< per round and contender
  int rounds = 3;                   ///< of each contender, in turns; the median counts
  int starts = 25;                  ///< starts of new nodes, for each contender and case
  std::uint64_t late_readers = 50;  ///< per round and contender
};

/// The time that the recording of fields adds to a getter, after the first access to the field in a sample.
std::vector<Figure> getter_overhead(const Scale& scale);

/// The time from the getter that widens the mask until the publisher on another host has applied the mask.
std::vector<Figure> str_response(const Scale& scale);
/// The time from before a node opens to the first sample of a publisher on another host.
std::vector<Figure> first_sample_new_nodes(const Scale& scale);
/// The time from before a node subscribes to the first sample. The publisher's node knows this node already.
std::vector<Figure> first_sample_late_reader(const Scale& scale);

/// The time of the publishing thread with readers that all ask for other fields, against readers that all ask
/// for the same fields.
std::vector<Figure> publish_64_masks(const Scale& scale);

/// The anonymous memory of a node with ten topics, beyond that of Cyclone DDS.
std::vector<Figure> node_anonymous_memory();

}  // namespace sft::bench
