// The groups of this benchmark: how costs grow with readers, masks and nodes. Each group runs SFT and its
// references in turns, between hosts that it makes itself, and returns figures.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "bench/common/report.h"

namespace sft::bench {

inline constexpr std::size_t emulated_hosts = 8;  ///< on which readers run, besides the host of the publisher

struct ManyScale {
  bool quick = false;
  int rounds = 3;         ///< of each contender, in turns; the median counts
  double settled_s = 30;  ///< how long nodes have been idle before they are measured
  double joining_s = 60;  ///< how long nodes may take to find each other
  /// How long idle nodes are measured in a round: longer than the pause between any two things that they say.
  double window_s = 45;
};

/// 16 readers of a cloud of 16 kB on eight hosts, each with a mask of its own: the bytes that leave the
/// publisher's host.
std::vector<Figure> masks_16(const ManyScale& scale);
/// The same with 64 readers, the time until these bytes have settled, and the processor time of a sample,
/// also over what raw UDP takes.
std::vector<Figure> masks_64(const ManyScale& scale);
/// Three readers with three masks, two of which have the data of the cloud: bytes from the first sample on.
std::vector<Figure> three_masks(const ManyScale& scale);

/// 1 + 64 nodes on eight hosts that start at once: time, bytes and processor time until all are matched.
std::vector<Figure> join_64(const ManyScale& scale);

/// 25 to 200 nodes with ten endpoints each, or 12 to 50 if quick: what it takes until all are matched, what
/// an idle node receives, and the exponents with which both grow. One round.
std::vector<Figure> growth(const ManyScale& scale);

// Curves: the costs of SFT and of Cyclone DDS at four sizes each, in turns, and their exponents.

/// 1 to 64 readers of a cloud of 16 kB on up to eight hosts, which all ask for its data; then 64 readers with
/// 1 to 64 different masks. What a sample costs.
std::vector<Figure> readers(const ManyScale& scale);
/// 2 to 32 nodes with ten endpoints each, as in growth().
std::vector<Figure> nodes(const ManyScale& scale);
/// 8 to 512 fields of 4 bytes: what a sample costs of which one reader asks for one field, and for every
/// other one, and the time until a request for another field is in force.
std::vector<Figure> fields(const ManyScale& scale);
/// Samples of 64 bytes to 32 MiB, which are sent reliably: what each costs.
std::vector<Figure> sizes(const ManyScale& scale);

/// The traffic, processor time and memory of 32 nodes on eight hosts, and of two, that have been idle.
std::vector<Figure> idle(const ManyScale& scale);

/// The worst of 25 samples of 6.3 MB.
std::vector<Figure> worst_large(const ManyScale& scale);
/// Small samples between hosts that sleep in between: latency, and the processor time of both sides. Where
/// TCP is the reference, raw UDP is measured, too: it is the least that any way over UDP takes.
std::vector<Figure> paced(const ManyScale& scale);

/// The highest rate of samples of 4 MiB without the help of interfaces, and with 4 MiB of receive buffer.
std::vector<Figure> bulk_without(const ManyScale& scale);
/// Loans over UDP beside publish(message): the time to the callback, and the highest rate.
std::vector<Figure> loans(const ManyScale& scale);

/// publish(message) in shared memory, to a reader that sleeps.
std::vector<Figure> shm_publish(const ManyScale& scale);
/// wait() in shared memory at 200 Hz: the default of SubscriberOptions::spin beside others.
std::vector<Figure> shm_wait(const ManyScale& scale);

/// The time until a request for another field is in force, also beside the least that it takes where no
/// listener of Cyclone DDS may wait.
std::vector<Figure> response(const ManyScale& scale);
/// publish(message) to 64 readers: its time with one mask, and the allocations with 64.
std::vector<Figure> publish_to_64(const ManyScale& scale);

}  // namespace sft::bench
