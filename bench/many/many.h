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

/// Measures the bytes that leave the publisher's host for 16 readers of a cloud of 16 kB on eight hosts,
/// each with a mask of its own.
std::vector<Figure> masks_16(const ManyScale& scale);
/// Measures the bytes of masks_16() with 64 readers. Also measures the time until these bytes have settled,
/// and the processor time of a sample, both in total and beyond that of raw UDP.
std::vector<Figure> masks_64(const ManyScale& scale);
/// Measures the bytes from the first sample on for three readers with three masks, two of which include the
/// data of the cloud.
std::vector<Figure> three_masks(const ManyScale& scale);

/// Measures time, bytes and processor time until 1 + 64 nodes on eight hosts, which start together, are all
/// matched.
std::vector<Figure> join_64(const ManyScale& scale);

/// Measures 25 to 200 nodes with ten endpoints each, or 12 to 50 if quick: the costs until all are matched,
/// the bytes that an idle node receives, and the exponents with which both grow. One round.
std::vector<Figure> growth(const ManyScale& scale);

// The following functions measure the costs of SFT and of Cyclone DDS in turns, at four sizes each. They also
// return the exponents with which the costs grow.

/// Measures the costs of a sample for readers of a cloud of 16 kB on up to eight hosts: first for 1 to 64
/// readers that all request its data, then for 64 readers with 1 to 64 different masks.
std::vector<Figure> readers(const ManyScale& scale);
/// Measures the costs of 2 to 32 nodes with ten endpoints each, as in growth().
std::vector<Figure> nodes(const ManyScale& scale);
/// Measures messages of 8 to 512 fields of 4 bytes: the costs of a sample for one reader that requests one
/// field, and for one that requests every other field, and the time until a request for another field is in
/// force.
std::vector<Figure> fields(const ManyScale& scale);
/// Measures the costs of samples of 64 bytes to 32 MiB that are sent reliably.
std::vector<Figure> sizes(const ManyScale& scale);

/// Measures the traffic, processor time and memory of 32 idle nodes on eight hosts, and of two idle nodes.
std::vector<Figure> idle(const ManyScale& scale);

/// Measures small samples between hosts that sleep in between: latency, and the processor time of both
/// sides. If TCP is the reference, raw UDP is measured, too, because it is the least that any transfer by
/// UDP takes.
std::vector<Figure> paced(const ManyScale& scale);

/// Measures the highest rate of samples of 4 MiB without offloads of interfaces, and with a receive buffer
/// of 4 MiB.
std::vector<Figure> bulk_without(const ManyScale& scale);
}  // namespace sft::bench
