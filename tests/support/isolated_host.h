// An isolated host for a test or a benchmark: private network, /dev/shm, /tmp and process ids. It does not
// meet other programs of the machine, and leaves nothing behind when it ends, even if it is killed.
#pragma once

#include <functional>
#include <string>

#include "sft/result.h"

namespace sft::test {

/// Calls `run` in a process of a new host, whose only interface is the loopback, and ends the calling
/// process with its exit code. All processes of the host end with `run`. Call this before there are threads.
/// If the system allows neither root nor user namespaces, `run` is called in this process, its result is
/// returned, and isolation_refusal() says why.
int run_isolated(const std::function<int()>& run);

/// Returns why this program is not isolated; empty if it is. Tests that need isolation skip otherwise.
const std::string& isolation_refusal();

// mount_own_shm() mounts an empty /dev/shm. mount_own_memory() also mounts an empty /tmp, in which the
// project's programs stay visible. REQUIRES: the caller has its own mount namespace, made by an isolated
// process.
Result<void> mount_own_shm();
Result<void> mount_own_memory();

/// Gives /dev/shm another size while this object lives.
class ShmOfSize {
 public:
  explicit ShmOfSize(unsigned mebibytes);
  ~ShmOfSize();
  ShmOfSize(const ShmOfSize&) = delete;
  ShmOfSize& operator=(const ShmOfSize&) = delete;
};

/// Returns the directory of the running program, which also has the other programs of the project.
const std::string& program_directory();

}  // namespace sft::test
