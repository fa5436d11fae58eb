// Processes of a benchmark, each on a core.
#pragma once

#include <sys/types.h>

#include <functional>

namespace sft::bench {

void pin_to_core(int core);

/// Calls `run` in a new process, whose exit code is the result. The process is killed when the calling
/// process ends. The process is also killed after five minutes, because it then counts as hanging.
pid_t start_process(const std::function<int()>& run);
/// Does the same as start_process(), with the process pinned to a core.
pid_t start_on_core(int core, const std::function<int()>& run);
/// Waits until the process has ended. Returns true if its exit code was 0.
bool succeeds(pid_t process);

/// Returns the user and system time of all threads of a running process; 0 if there is no such process.
double cpu_s(pid_t process);

}  // namespace sft::bench
