// The daemon that serves this host, seen from another process.
#pragma once

#include <string>

#include "shm_transport/host_file.h"
#include "shm_transport/sftd/exit_code.h"

namespace sft::shm {

class RunningDaemon {
 public:
  struct Absence {
    ExitCode code;
    std::string reason;
  };
  static tl::expected<RunningDaemon, Absence> find();

  pid_t pid() const { return watch_.file().pid; }
  uid_t user() const { return user_; }
  bool lives() const { return watch_.daemon_lives(); }

  /// Its process, to signal and to wait for. Its pid may mean another process here than where it wrote it
  /// down: whether this one holds the daemon's lock is checked. Errc::no_permission for another user's.
  Result<Descriptor> process() const;
  /// By a signal or a debugger; false where that cannot be seen.
  bool is_stopped() const;

 private:
  RunningDaemon(HostWatch watch, uid_t user) : watch_(std::move(watch)), user_(user) {}
  HostWatch watch_;
  uid_t user_;
};

}  // namespace sft::shm
