// Starting sftd from an ordinary program, which it outlives: a session of its own, none of the program's
// descriptors, signal settings or directory, and never its child for longer than it takes to begin.
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>

#include "shm_transport/file_lock.h"
#include "shm_transport/shm_transport.h"

namespace sft::shm {

class DaemonLaunch {
 public:
  static Result<DaemonLaunch> begin(const ShmOptions& options);
  DaemonLaunch(DaemonLaunch&&) noexcept = default;
  DaemonLaunch& operator=(DaemonLaunch&&) = delete;

  struct Outcome {
    std::string complaint;  ///< empty if it runs, or found another one running
  };
  /// Once it has begun or failed. Does not wait.
  std::optional<Outcome> poll();

 private:
  DaemonLaunch(pid_t child, Descriptor complaints) : child_(child), complaints_(std::move(complaints)) {}

  pid_t child_;            ///< the process that goes once the daemon, its grandchild, is ready
  Descriptor complaints_;  ///< its standard error, closed when it goes
  std::string text_;
};

}  // namespace sft::shm
