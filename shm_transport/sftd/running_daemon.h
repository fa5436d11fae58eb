// The daemon that serves this host, as the commands `sftd status` and `sftd stop` find it from another
// process.
#pragma once

#include <string>

#include "shm_transport/host/host_file.h"
#include "shm_transport/sftd/exit_code.h"

namespace sft::shm {

class RunningDaemon {
 public:
  struct Absence {
    ExitCode code;
    std::string reason;
  };
  static tl::expected<RunningDaemon, Absence> find();

  pid_t pid() const { return pid_; }
  uid_t user() const { return user_; }
  /// Returns a text that says that the daemon's files were removed, and what to do; empty if the files
  /// exist.
  const std::string& problem() const { return problem_; }

  /// Returns a pidfd of the daemon, to send it a signal and to wait for its end. If the daemon has another
  /// pid namespace, its pid may belong to another process here. So the function checks that the process
  /// holds the daemon's lock. Errc::no_permission: the daemon belongs to another user.
  Result<Descriptor> process() const;
  /// Returns whether a signal or a debugger has stopped the daemon; false if this process cannot see that.
  bool is_stopped() const;

 private:
  RunningDaemon(pid_t pid, uid_t user, const char* lock, std::string problem = {})
      : pid_(pid), user_(user), lock_(lock), problem_(std::move(problem)) {}

  pid_t pid_;
  uid_t user_;
  const char* lock_;  ///< path of a file that the daemon has locked
  std::string problem_;
};

}  // namespace sft::shm
