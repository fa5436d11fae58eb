// The questions of this benchmark: how fast what was negotiated comes true, and what that costs. Each runs
// our side and its reference in turns and returns figures.
#pragma once

#include <cstdint>
#include <vector>

#include "bench/common/report.h"

namespace sft::bench {

struct Scale {
  std::uint64_t messages = 400;     ///< per round and contender
  int rounds = 3;                   ///< of each contender, in turns; the median counts
  int starts = 25;                  ///< of new nodes, for each contender and case
  std::uint64_t late_readers = 50;  ///< per round and contender
};

/// What noting that a field was read adds to its getter, after the first access to it in a sample.
std::vector<Figure> getter_overhead(const Scale& scale);

/// From the getter that widens the mask to the publisher having applied it, between two hosts.
std::vector<Figure> str_response(const Scale& scale);
/// From before a node opens to the first sample of a publisher on another host.
std::vector<Figure> first_sample_new_nodes(const Scale& scale);
/// From before a node that is known to the publisher's subscribes to the first sample.
std::vector<Figure> first_sample_late_reader(const Scale& scale);

/// Of the publishing thread, with readers that all ask for other fields, against readers that all ask for the
/// same.
std::vector<Figure> publish_64_masks(const Scale& scale);

/// Of a node with ten topics, beyond that of Cyclone DDS.
std::vector<Figure> node_anonymous_memory();

}  // namespace sft::bench
