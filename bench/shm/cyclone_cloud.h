// Clouds with Cyclone DDS over iceoryx. The thread that sleeps until a sample comes calls the reader
// directly, without a waitset.
#pragma once

#include <vector>

#include "bench/common/roudi.h"
#include "bench/common/transfer.h"

namespace sft::bench {

// All functions return one-way times in microseconds, until height and width are read.

/// The standard message, which is serialized into shared memory.
std::vector<double> cyclone_standard(const Transfer& transfer, const Roudi& roudi);
/// A loan of a message of fixed size, which is not serialized.
std::vector<double> cyclone_fixed(const Transfer& transfer, const Roudi& roudi);

}  // namespace sft::bench
