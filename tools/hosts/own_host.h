// Functions that give a process tree what a host has in addition to its network: rights to make namespaces,
// and its own /dev/shm, /tmp and /proc. So the process tree has its own shared memory and its own daemon.
#pragma once

#include <filesystem>

#include "sft/result.h"

namespace sft::hosts {

/// Makes the calling process root of a new user namespace, and moves it into new namespaces of the other
/// kinds (`CLONE_NEWNET | ...`) that belong to it. REQUIRES: the process has one thread.
Result<void> enter_user_namespace(int other_kinds);

/// Returns the directory of the running program. The other programs of the project are in the same
/// directory.
const std::filesystem::path& program_directory();

// The following functions mount new file systems over /dev/shm, /tmp and /proc. REQUIRES: the calling thread
// is in its own mount namespace, and program_directory() was called before the /proc of the machine was
// hidden.

/// Must be called before the next functions, because their mounts would otherwise be visible outside.
Result<void> make_mounts_private();
Result<void> mount_own_shm(unsigned mebibytes);
/// If the project was built in /tmp, the folder in /tmp that has it stays visible: programs find messages and
/// other files of the tree by paths relative to their own.
Result<void> mount_own_tmp();
Result<void> mount_own_proc();

}  // namespace sft::hosts
