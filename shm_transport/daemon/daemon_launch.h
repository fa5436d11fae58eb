// Starts sftd from an ordinary program. The daemon outlives the program: it has a session of its own, and
// does not inherit the descriptors, the signal settings or the directory of the program. It is no child of
// the program any more as soon as it has started.
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
  /// `places`: where the file of sftd may be, if the options do not name it.
  static Result<DaemonLaunch> begin(const ShmOptions& options, const DaemonPlaces& places);
  DaemonLaunch(DaemonLaunch&& other) noexcept
      : child_(std::exchange(other.child_, 0)),
        error_output_(std::move(other.error_output_)),
        error_text_(std::move(other.error_text_)) {}
  DaemonLaunch& operator=(DaemonLaunch&&) = delete;
  /// Kills the child that still waits for the daemon, so that no child remains. A daemon that it may have
  /// started goes on.
  ~DaemonLaunch();

  struct Outcome {
    std::string error;  ///< empty if the daemon runs, or has found another daemon running
  };
  /// Returns the outcome after the daemon has started or failed, and nothing before. Does not wait.
  std::optional<Outcome> poll();

 private:
  DaemonLaunch(pid_t child, Descriptor error_output)
      : child_(child), error_output_(std::move(error_output)) {}

  bool child_is_gone() noexcept;

  pid_t child_;  ///< the process that ends as soon as its grandchild, the daemon, is ready; 0: ended
  Descriptor error_output_;  ///< the child's standard error; the child closes it when it ends
  std::string error_text_;   ///< what was read from it
};

}  // namespace sft::shm
