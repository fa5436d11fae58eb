// An isolated host for a test or a benchmark, with its own network, /dev/shm, /tmp and process ids. Programs
// on the host do not meet other programs of the machine. The host leaves nothing behind when it ends, even if
// it is killed.
#pragma once

#include <functional>
#include <string>

#include "sft/result.h"

namespace sft::test {

/// Makes a new host whose only interface is the loopback, and calls `run` in a process of it. Then ends the
/// calling process with the exit code of `run`. All processes of the host end with `run`. Must be called
/// before the process has other threads. If the system allows neither root nor user namespaces, calls `run`
/// in this process and returns its result; isolation_refusal() then gives the reason.
int run_isolated(const std::function<int()>& run);

/// Returns the reason why this program is not isolated, or "" if it is. Tests that need isolation are skipped
/// if there is a reason.
const std::string& isolation_refusal();

// mount_own_shm() mounts an empty /dev/shm. mount_own_memory() also mounts an empty /tmp, in which the
// project's programs stay visible. REQUIRES: the caller has its own mount namespace, made by an isolated
// process.
Result<void> mount_own_shm();
Result<void> mount_own_memory();

/// Gives /dev/shm another size. The destructor restores the former size.
class ShmOfSize {
 public:
  explicit ShmOfSize(unsigned mebibytes);
  ~ShmOfSize();
  ShmOfSize(const ShmOfSize&) = delete;
  ShmOfSize& operator=(const ShmOfSize&) = delete;
};

/// Returns the directory of the running program. The other programs of the project are in the same directory.
const std::string& program_directory();

}  // namespace sft::test
