// Starting sftd from an ordinary program, which it outlives: a session of its own, none of the program's
// descriptors, signal settings or directory, and never its child for longer than it takes to begin.
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <utility>

#include "shm_transport/host/file_lock.h"
#include "shm_transport/host/shm_options.h"

namespace sft::shm {

class DaemonLaunch {
 public:
  static Result<DaemonLaunch> begin(const ShmOptions& options);
  DaemonLaunch(DaemonLaunch&& other) noexcept
      : child_(std::exchange(other.child_, 0)),
        complaints_(std::move(other.complaints_)),
        text_(std::move(other.text_)) {}
  DaemonLaunch& operator=(DaemonLaunch&&) = delete;
  /// Leaves no child behind: ends its wait, but not the daemon that it may have started.
  ~DaemonLaunch();

  struct Outcome {
    std::string complaint;  ///< empty if it runs, or found another one running
  };
  /// Once it has begun or failed. Does not wait.
  std::optional<Outcome> poll();

 private:
  DaemonLaunch(pid_t child, Descriptor complaints) : child_(child), complaints_(std::move(complaints)) {}

  bool child_is_gone() noexcept;

  pid_t child_;            ///< the process that goes once the daemon, its grandchild, is ready; 0: gone
  Descriptor complaints_;  ///< its standard error, closed when it goes
  std::string text_;
};

}  // namespace sft::shm
