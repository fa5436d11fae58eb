// The daemon that serves this host, seen from another process.
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
  /// What is wrong with it, and what to do; empty if nothing is.
  const std::string& complaint() const { return complaint_; }

  /// Its process, to signal and to wait for. Its pid may mean another process here than where it wrote it
  /// down: whether this one holds the daemon's lock is checked. Errc::no_permission for another user's.
  Result<Descriptor> process() const;
  /// By a signal or a debugger; false where that cannot be seen.
  bool is_stopped() const;

 private:
  RunningDaemon(pid_t pid, uid_t user, const char* lock, std::string complaint = {})
      : pid_(pid), user_(user), lock_(lock), complaint_(std::move(complaint)) {}

  pid_t pid_;
  uid_t user_;
  const char* lock_;  ///< a file that it has locked
  std::string complaint_;
};

}  // namespace sft::shm
