// Starts sftd from an ordinary program. The daemon outlives the program: it has a session of its own, and
// does not inherit the descriptors, the signal settings or the directory of the program. Once the daemon
// has started, it is not a child of the program any more.
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <utility>

#include "shm_transport/daemon/daemon_search.h"
#include "shm_transport/host/file_lock.h"
#include "shm_transport/host/shm_options.h"

namespace sft::shm {

class DaemonLaunch {
 public:
  /// Begins to start the daemon. `places` are the possible paths of sftd's file, which are tried if the
  /// options do not name the file.
  static Result<DaemonLaunch> begin(const ShmOptions& options, const DaemonPlaces& places);
  DaemonLaunch(DaemonLaunch&& other) noexcept
      : child_(std::exchange(other.child_, 0)),
        error_output_(std::move(other.error_output_)),
        error_text_(std::move(other.error_text_)) {}
  DaemonLaunch& operator=(DaemonLaunch&&) = delete;
  /// Kills the child process if it still waits for the daemon, so that no child process remains. If the
  /// child has already started a daemon, that daemon continues to run.
  ~DaemonLaunch();

  struct Outcome {
    std::string error;  ///< the error text; empty if the daemon runs, or has found another daemon running
  };
  /// Returns the outcome once the daemon has started or failed; before that, returns nothing. Does not
  /// wait.
  std::optional<Outcome> poll();

 private:
  DaemonLaunch(pid_t child, Descriptor error_output)
      : child_(child), error_output_(std::move(error_output)) {}

  bool child_is_gone() noexcept;

  pid_t child_;  ///< the process that ends as soon as its grandchild, the daemon, is ready; 0: it has ended
  Descriptor error_output_;  ///< the child's standard error, which the child closes when it ends
  std::string error_text_;   ///< the text that was read from `error_output_`
};

}  // namespace sft::shm
