// The groups of this benchmark: how costs grow with readers, masks and nodes. Each group runs SFT and its
// references in turns, between hosts that it makes itself, and returns figures.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "bench/common/report.h"

namespace sft::bench {

/// Number of hosts with readers, in addition to the host of the publisher.
inline constexpr std::size_t emulated_hosts = 8;

struct ManyScale {
  bool quick = false;
  int rounds = 3;         ///< rounds of each contender, in turns; the median is used
  double settled_s = 30;  ///< the time for which nodes are idle before they are measured
  double joining_s = 60;  ///< the longest time in which nodes have to find each other
  /// The time for which idle nodes are measured in a round. It is longer than the period of any of their
  /// control messages.
  double window_s = 45;
};

/// Measures 64 readers of a cloud of 16 kB on eight hosts, each with a mask of its own: the bytes of a sample
/// that leave the publisher's host, the time until these bytes have settled, and the processor time of a
/// sample.
std::vector<Figure> masks_64(const ManyScale& scale);

/// Measures time, bytes and processor time until 1 + 64 nodes on eight hosts, which start together, are all
/// matched.
std::vector<Figure> join_64(const ManyScale& scale);

/// Measures 25 to 200 nodes with ten endpoints each, or 12 to 50 if quick: the costs until all are matched,
/// the bytes that an idle node receives, and the exponents with which both grow. One round.
std::vector<Figure> growth(const ManyScale& scale);

/// Measures the traffic, processor time and memory of 32 idle nodes on eight hosts, and of two idle nodes.
std::vector<Figure> idle(const ManyScale& scale);

}  // namespace sft::bench
