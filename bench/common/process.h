// Processes of a benchmark, each on a core.
#pragma once

#include <sys/types.h>

#include <functional>

namespace sft::bench {

void pin_to_core(int core);

/// Runs it in a new process, pinned to a core, which ends with its result as exit code, when this process
/// ends, or after five minutes, since it hangs then.
pid_t start_on_core(int core, const std::function<int()>& run);
/// Waits until it has ended; whether its exit code was 0.
bool succeeds(pid_t process);

}  // namespace sft::bench
