// Options of the nodes of benchmarks.
#pragma once

#include <sched.h>

#include <string>
#include <utility>

#include "sft/options.h"

namespace sft::bench {

/// Returns options with which all threads of the node stay on the CPUs of the calling thread, which has a
/// core of its own in most benchmarks. By default, a node's threads do not inherit the CPUs of the thread
/// that opens it (NodeOptions::Threads).
inline NodeOptions node_options(std::string name, TransportChoice transport) {
  cpu_set_t set;
  CPU_ZERO(&set);
  sched_getaffinity(0, sizeof set, &set);
  ThreadSettings settings;
  for (unsigned cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
    if (CPU_ISSET(cpu, &set)) settings.cpus.push_back(cpu);
  }
  return {.name = std::move(name),
          .transport = transport,
          .threads = {settings, settings, settings, settings, settings}};
}

inline NodeOptions udp_node_options(std::string name) {
  return node_options(std::move(name), TransportChoice::udp);
}

}  // namespace sft::bench
