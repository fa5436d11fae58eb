// The groups of this benchmark: how soon the result of a negotiation takes effect, and its costs. Each group
// runs SFT and its reference in turns and returns figures.
#pragma once

#include <cstdint>
#include <vector>

#include "bench/common/report.h"

namespace sft::bench {

struct Scale {
  std::uint64_t messages = 400;     ///< the number per round and contender
  int rounds = 3;                   ///< rounds of each contender, in turns; the median is used
  int starts = 25;                  ///< starts of new nodes, for each contender and case
  std::uint64_t late_readers = 50;  ///< the number per round and contender
};

/// The time that recording adds to a getter, after the first access to the field in a sample.
std::vector<Figure> getter_overhead(const Scale& scale);

/// The time from the getter call that widens the mask until the publisher on another host has applied the
/// mask.
std::vector<Figure> str_response(const Scale& scale);
/// The time from before a node opens to the first sample of a publisher on another host.
std::vector<Figure> first_sample_new_nodes(const Scale& scale);
/// The time from before a node subscribes until the first sample. The publisher's node already knows this
/// node.
std::vector<Figure> first_sample_late_reader(const Scale& scale);

/// The duration of publish() with readers that each ask for other fields, compared with readers that all ask
/// for the same fields.
std::vector<Figure> publish_64_masks(const Scale& scale);

/// The anonymous memory of a node with ten topics, beyond that of Cyclone DDS.
std::vector<Figure> node_anonymous_memory();

}  // namespace sft::bench
