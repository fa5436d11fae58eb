// The least time to wake a process: a word in shared memory and the system call.
#pragma once

#include <vector>

#include "bench/common/transfer.h"

namespace sft::bench {

/// One-way times in microseconds. The reader always sleeps, whatever `transfer` says.
std::vector<double> raw_futex_times(const Transfer& transfer);

}  // namespace sft::bench
