// A host of its own for a test or a benchmark: private network, /dev/shm, /tmp and process ids. It does not
// meet other programs of the machine, and nothing of it is left when it ends, even if it is killed.
#pragma once

#include <functional>
#include <string>

#include "sft/result.h"

namespace sft::test {

/// Calls `run` as a process of a new host, whose only interface is the loopback, and ends the calling process
/// with its exit code. All processes that it started end with it. Call it before there are threads. Where the
/// system allows neither root nor user namespaces, `run` is called where it stands, its result is returned,
/// and isolation_refusal() says why.
int run_isolated(const std::function<int()>& run);

/// Empty if this program is isolated. Tests that need isolation are skipped otherwise.
const std::string& isolation_refusal();

// These functions mount an empty /dev/shm, or that and an empty /tmp, in which the programs stay in sight.
// REQUIRES: a mount namespace of one's own, made by a process that is isolated.
Result<void> mount_own_shm();
Result<void> mount_own_memory();

/// Gives /dev/shm another size as long as this object lives.
class ShmOfSize {
 public:
  explicit ShmOfSize(unsigned mebibytes);
  ~ShmOfSize();
  ShmOfSize(const ShmOfSize&) = delete;
  ShmOfSize& operator=(const ShmOfSize&) = delete;
};

/// Directory of the running program, which holds the other programs of the project, too.
const std::string& program_directory();

}  // namespace sft::test
