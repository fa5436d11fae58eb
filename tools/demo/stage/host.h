// A host of the demo: a process tree that runs one or more roles, each in a process of its own. Where
// namespaces can be made, it is a machine of its own to whatever runs there; otherwise it is just processes
// on this machine.
//
// The first process of the tree adopts what the roles leave behind (the daemon of the shared memory). When
// the roles have ended, when one has failed, with SIGTERM, or when the demo ends in whatever way, it ends all
// that is left, so that nothing that the demo started goes on.
#pragma once

#include <sys/types.h>

#include <functional>
#include <string>
#include <vector>

#include "sft/result.h"
#include "tools/hosts/network.h"

namespace sft::demo {

/// The work of one process of a host, which goes on until the demo orders the end, or fails.
struct Role {
  std::string name;
  std::function<Result<void>()> run;
};

struct HostSettings {
  const hosts::NetworkNamespace* network = nullptr;  ///< null: the host is this machine
  unsigned shm_mebibytes = 256;                      ///< of its own /dev/shm; the daemon takes memory by that
};

/// Tries in a child process whether hosts can be made. The error says why not.
Result<void> try_isolation();

/// Root may make hosts. Any other user becomes root of a user namespace, where the system lets users have
/// one, for the rest of the calling process. REQUIRES: the process has one thread.
Result<void> become_root();

/// Starts the host, and returns its first process. REQUIRES: the calling process has
/// one thread.
Result<pid_t> start_host(const HostSettings& settings, const std::vector<Role>& roles);

}  // namespace sft::demo
