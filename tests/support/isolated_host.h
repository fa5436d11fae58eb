// A host of one's own for a test or a benchmark: private network, /dev/shm, /tmp and process ids. It meets
// nothing that else runs on the machine, and nothing of it is left when it ends, killed or not.
#pragma once

#include <functional>
#include <string>

#include "sft/typesupport/result.h"

namespace sft::test {

/// Calls `run` as a process of a new host, of which the only interface is the loopback, and ends this one
/// with its exit code; all that it started ends with it. Call it before there are threads. Where the system
/// allows neither root nor user namespaces, `run` is called where it stands, its result is returned, and
/// isolation_refusal() says why.
int run_isolated(const std::function<int()>& run);

/// Empty if this program is isolated: tests that need it skip by this otherwise.
const std::string& isolation_refusal();

// These functions mount an empty /dev/shm, or that and an empty /tmp, in which the programs stay in sight.
// REQUIRES: a mount namespace of one's own, made by a process that is isolated.
Result<void> mount_own_shm();
Result<void> mount_own_memory();

/// A /dev/shm of another size, while it lives.
class ShmOfSize {
 public:
  explicit ShmOfSize(unsigned mebibytes);
  ~ShmOfSize();
  ShmOfSize(const ShmOfSize&) = delete;
  ShmOfSize& operator=(const ShmOfSize&) = delete;
};

/// Directory of the running program, where the project's others are too.
const std::string& program_directory();

}  // namespace sft::test
