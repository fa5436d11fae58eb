// A node's threads do not take over the CPUs of the thread that opens it (NodeThreads). Here each side has a
// core of its own, with all its threads.
#pragma once

#include <sched.h>

#include "sft/options.h"

namespace sft::bench {

/// All threads of a node on the CPUs that the calling thread may use.
inline NodeThreads threads_beside_this_one() {
  cpu_set_t set;
  CPU_ZERO(&set);
  sched_getaffinity(0, sizeof set, &set);
  ThreadSettings settings;
  for (unsigned cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
    if (CPU_ISSET(cpu, &set)) settings.cpus.push_back(cpu);
  }
  return {settings, settings, settings, settings, settings};
}

}  // namespace sft::bench
