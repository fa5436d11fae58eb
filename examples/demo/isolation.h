// What makes a process tree a host of its own, beside its network: own processes, own /dev/shm and own /tmp,
// so that it has its own shared memory and its own daemon.
#pragma once

#include "examples/demo/network.h"

namespace sft::demo {

struct HostSettings {
  const NetworkNamespace* network = nullptr;
  unsigned shared_memory_mib = 256;  ///< of /dev/shm; the daemon takes memory by that
};

/// Moves the calling process into the network and mounts an empty /dev/shm and /tmp that only it and its
/// children see. Its next child becomes the first process of a new process namespace; when that one ends, the
/// kernel ends all in there.
Result<void> leave_this_host(const HostSettings& settings);
/// In that child: makes /proc tell of the new process namespace.
Result<void> mount_own_proc();

/// Whether this process may do all that, once become_root() was called. The error says why not.
Result<void> try_isolation();

/// Root may make hosts. Any other user becomes root of a user namespace, where the system lets users have
/// one, for the rest of the calling process. REQUIRES: it has one thread.
Result<void> become_root();

}  // namespace sft::demo
