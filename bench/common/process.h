// Processes of a benchmark, each on a core.
#pragma once

#include <sys/types.h>

#include <functional>

namespace sft::bench {

void pin_to_core(int core);

/// Calls `run` in a new process, pinned to a core, whose exit code is the result. The process is killed when
/// this process ends, or after five minutes, since it then hangs.
pid_t start_on_core(int core, const std::function<int()>& run);
/// Waits until the process has ended. True if its exit code was 0.
bool succeeds(pid_t process);

}  // namespace sft::bench
