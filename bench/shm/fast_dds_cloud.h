// Clouds with Fast DDS in shared memory. The thread that sleeps until a sample comes calls the reader
// directly, without a waitset.
#pragma once

#include <vector>

#include "bench/common/transfer.h"

namespace sft::bench {

// All functions return one-way times in microseconds, until height and width are read.

/// The standard message by the shared-memory transport.
std::vector<double> fast_dds_standard(const Transfer& transfer);
/// A loan of a message of fixed size by data sharing, in which readers see the writer's memory.
std::vector<double> fast_dds_fixed(const Transfer& transfer);

}  // namespace sft::bench
