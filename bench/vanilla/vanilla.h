// The groups of this benchmark. "Vanilla" is a node of plain Cyclone DDS that knows nothing of SFT. All but
// the first samples are point clouds of 6.3 MB.
#pragma once

#include <cstdint>
#include <vector>

#include "bench/common/report.h"

namespace sft::bench {

struct VanillaScale {
  int rounds = 3;              ///< rounds of each program, in turns; the median is used
  std::uint64_t samples = 40;  ///< number of samples per round and program
  int starts = 10;             ///< number of starts of readers, for each program
  double idle_s = 20;          ///< the time in which idle nodes are measured
};

/// Measures the processor time of a program that publishes to a vanilla reader on another host, by loans
/// and by structs, compared with a program that writes the same struct by Cyclone DDS.
std::vector<Figure> vanilla_write(const VanillaScale& scale);
/// Measures the processor time of a program that subscribes to a vanilla writer on another host, compared
/// with a vanilla reader. Counts the copies of a message that exist for two subscribers of one program.
std::vector<Figure> vanilla_read(const VanillaScale& scale);
/// Measures the time from the start of a vanilla reader until its first sample from another host.
std::vector<Figure> vanilla_first_sample(const VanillaScale& scale);
/// Measures the latency within a host while a vanilla reader of the same samples is stopped, compared with
/// the latency without such a reader.
std::vector<Figure> local_beside_stopped_vanilla(const VanillaScale& scale);
/// Measures the bytes per sample that a host with a subscriber receives, before and after a vanilla reader
/// on a third host has joined.
std::vector<Figure> bytes_to_sft_readers(const VanillaScale& scale);
/// Measures idle nodes while there is no vanilla node, compared with nodes for which communication with
/// vanilla nodes is turned off.
std::vector<Figure> idle_without_vanilla(const VanillaScale& scale);

}  // namespace sft::bench
